//! The bill of materials: everything inside of the program, as CycloneDX.

use std::path::Path;

use serde_json::{Value, json};

use super::copyright::{Shipped, Source, shipped};
use super::{Built, tools, write};
use crate::run::{self, StepResult, output};

/// Checks a bill against the schema.
const CHECK: &str = "
import sys
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
wrong = JsonStrictValidator(SchemaVersion.V1_6).validate_str(open(sys.argv[1]).read())
sys.exit(f'{sys.argv[1]}: {wrong}' if wrong else 0)
";

/// Writes and checks it.
pub fn make(folder: &Path, built: &Built) -> StepResult {
    let shipped = shipped()?;
    for source in [Source::Cargo, Source::Npm, Source::Native] {
        if !shipped.iter().any(|it| it.source == source) {
            return Err(format!("the bill of materials has no package of {source:?}"));
        }
    }
    let commit = output(run::git().args(["rev-parse", "HEAD"]))?;
    let time = ["-u", "-d", &format!("@{}", built.epoch), "+%Y-%m-%dT%H:%M:%SZ"];
    let time = output(std::process::Command::new("date").args(time))?;
    let bill = bill(&shipped, &built.version, commit.trim(), time.trim());
    let path = folder.join(format!("lafet-{}.cdx.json", built.version));
    write(&path, format!("{bill:#}\n"))?;
    output(tools::cyclonedx()?.args(["-c", CHECK]).arg(&path))?;
    println!("   {}: {} parts", path.display(), shipped.len());
    Ok(())
}

fn bill(shipped: &[Shipped], version: &str, commit: &str, time: &str) -> Value {
    let own = |it: &&Shipped| it.source == Source::Cargo && it.name.starts_with("lafet");
    let parts: Vec<Value> = shipped.iter().filter(|it| !own(it)).map(part).collect();
    json!({
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "serialNumber": format!("urn:uuid:{}", uuid(commit)),
        "version": 1,
        "metadata": {
            "timestamp": time,
            "component": {
                "type": "application",
                "bom-ref": "lafet",
                "name": "lafet",
                "version": version,
                "licenses": [{ "expression": "Apache-2.0 OR MIT" }],
                "properties": [{ "name": "lafet:commit", "value": commit }],
            },
        },
        "components": parts,
    })
}

fn part(it: &Shipped) -> Value {
    let kind = match it.source {
        Source::Cargo => "cargo",
        Source::Npm => "npm",
        Source::Native => "generic",
    };
    let name = it.name.replace('@', "%40");
    let version = it.version.replace('+', "%2B");
    let purl = format!("pkg:{kind}/{name}@{version}");
    let mut part = json!({
        "type": "library",
        "bom-ref": purl,
        "name": it.name,
        "version": it.version,
        "purl": purl,
        "licenses": [{ "expression": it.licence }],
    });
    if let Some((algorithm, digest)) = &it.digest {
        part["hashes"] = json!([{ "alg": algorithm, "content": digest }]);
    }
    part
}

/// A UUID of form 8 with what the commit begins with: the same for the same commit.
fn uuid(commit: &str) -> String {
    let mut digits: Vec<char> = commit.chars().chain("0".repeat(32).chars()).take(32).collect();
    digits[12] = '8';
    digits[16] = 'a';
    let part = |from: usize, to: usize| digits[from..to].iter().collect::<String>();
    [part(0, 8), part(8, 12), part(12, 16), part(16, 20), part(20, 32)].join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_a_bill_is_that_of_its_commit() {
        let commit = "459c0be3ffffffffffffffffffffffffffffffff";
        assert_eq!(uuid(commit), "459c0be3-ffff-8fff-afff-ffffffffffff");
        assert_eq!(uuid("").len(), 36);
    }
}
