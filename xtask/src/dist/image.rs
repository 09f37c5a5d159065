//! The container image: the program alone, on nothing, as a layout of the Open Container Initiative.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::archive::pack;
use super::files::{lay, mode};
use super::{Built, clear, files, read, sums, tools, work, write};
use crate::run::{self, StepResult, output};

const LAYER: &str = "application/vnd.oci.image.layer.v1.tar+gzip";
const CONFIG: &str = "application/vnd.oci.image.config.v1+json";
const MANIFEST: &str = "application/vnd.oci.image.manifest.v1+json";
/// The user that it runs as; no name is needed, and no file with names is there.
const USER: &str = "10001:10001";
/// The hub's state, which a container is given as a volume.
const STATE: &str = "/var/lib/lafet";

/// Makes the archive of the layout in a folder; returns its path.
pub fn make(built: &Built, folder: &Path) -> Result<PathBuf, String> {
    let root = work(&format!("image-{}", built.arch.name))?;
    let layout = root.join("layout");
    let (digest, plain) = layer(built, &root, &layout)?;
    let config = blob(&layout, &config(built, &plain)?.to_string())?;
    let manifest = json!({
        "schemaVersion": 2,
        "mediaType": MANIFEST,
        "config": described(CONFIG, &layout, &config)?,
        "layers": [described(LAYER, &layout, &digest)?],
    });
    let manifest = blob(&layout, &manifest.to_string())?;
    let mut named = described(MANIFEST, &layout, &manifest)?;
    named["platform"] = json!({ "architecture": built.arch.name, "os": "linux" });
    named["annotations"] = json!({ "org.opencontainers.image.ref.name": name(built) });
    let index = json!({ "schemaVersion": 2, "manifests": [named] });
    write(&layout.join("index.json"), index.to_string())?;
    write(&layout.join("oci-layout"), json!({ "imageLayoutVersion": "1.0.0" }).to_string())?;
    let path = folder.join(format!("lafet-{}-oci-{}.tar", built.version, built.arch.name));
    pack(&layout, ".", &path, &built.epoch)?;
    inspect(&path, built)?;
    println!("   {}", path.display());
    Ok(path)
}

/// What engines call it.
fn name(built: &Built) -> String {
    format!("lafet:{}", built.version)
}

/// The only layer; its digest, and that of its contents unpacked.
fn layer(built: &Built, root: &Path, layout: &Path) -> Result<(String, String), String> {
    let tree = root.join("rootfs");
    clear(&tree)?;
    let shipped = files::all(built)?.into_iter();
    let wanted = ["usr/bin/", "usr/share/doc/lafet/copyright", "usr/share/doc/lafet/licences"];
    let kept: Vec<files::File> =
        shipped.filter(|it| wanted.iter().any(|start| it.path.starts_with(start))).collect();
    lay(&kept, &tree)?;
    let config = tree.join("etc/lafet/hub.toml");
    write(&config, files::CONFIG)?;
    for folder in ["var/lib", "tmp"] {
        std::fs::create_dir_all(tree.join(folder)).map_err(|e| e.to_string())?;
    }
    mode(&tree.join("tmp"), 0o1777)?;
    let tar = root.join("layer.tar");
    owned(&tree, &tar, &built.epoch)?;
    let plain = sums::of(&tar)?;
    output(tools::command("gzip", "gzip")?.args(["-9nf"]).arg(&tar))?;
    let digest = keep(layout, &read(&root.join("layer.tar.gz"))?)?;
    Ok((digest, plain))
}

/// Packs the tree, and the folder of the state, which belongs to the user of the image: a new volume takes its owner
/// and mode from it. Each path once, as podman takes no other layer.
fn owned(tree: &Path, tar: &Path, epoch: &str) -> StepResult {
    pack(tree, ".", tar, epoch)?;
    std::fs::create_dir_all(tree.join(&STATE[1..])).map_err(|e| e.to_string())?;
    let user = USER.split(':').next().unwrap_or_default();
    let mut state = tools::command("tar", "tar")?;
    state.arg("-rf").arg(tar).arg("-C").arg(tree).args(["--format=gnu", "--mode=0700"]);
    state.args([format!("--owner={user}"), format!("--group={user}"), format!("--mtime=@{epoch}")]);
    output(state.args(["--numeric-owner", "./var/lib/lafet"]))?;
    let listed = output(tools::command("tar", "tar")?.arg("-tf").arg(tar))?;
    let paths: BTreeSet<&str> = listed.lines().collect();
    match paths.len() == listed.lines().count() {
        true => Ok(()),
        false => Err(format!("a path is twice in the layer:\n{listed}")),
    }
}

fn config(built: &Built, layer: &str) -> Result<Value, String> {
    let date = ["-u", "-d", &format!("@{}", built.epoch), "+%Y-%m-%dT%H:%M:%SZ"];
    let date = output(std::process::Command::new("date").args(date))?;
    let commit = output(run::git().args(["rev-parse", "HEAD"]))?;
    Ok(json!({
        "created": date.trim(),
        "architecture": built.arch.name,
        "os": "linux",
        "config": {
            "User": USER,
            "ExposedPorts": { "8480/tcp": {} },
            "Env": [format!("STATE_DIRECTORY={STATE}"), "PATH=/usr/bin"],
            "Entrypoint": ["/usr/bin/lafet"],
            "Cmd": ["serve", "--no-browser", "--json", "--config", "/etc/lafet/hub.toml"],
            "Volumes": { STATE: {} },
            "WorkingDir": STATE,
            "StopSignal": "SIGTERM",
            "Labels": {
                "org.opencontainers.image.title": "lafet",
                "org.opencontainers.image.version": built.version,
                "org.opencontainers.image.revision": commit.trim(),
                "org.opencontainers.image.licenses": "Apache-2.0 OR MIT",
            },
        },
        "rootfs": { "type": "layers", "diff_ids": [format!("sha256:{layer}")] },
        "history": [{ "created": date.trim(), "created_by": "cargo xtask dist" }],
    }))
}

fn blob(layout: &Path, text: &str) -> Result<String, String> {
    keep(layout, text.as_bytes())
}

/// Puts a blob into the layout; its digest.
fn keep(layout: &Path, bytes: &[u8]) -> Result<String, String> {
    let folder = layout.join("blobs/sha256");
    let new = folder.join("new");
    write(&new, bytes)?;
    let digest = sums::of(&new)?;
    std::fs::rename(&new, folder.join(&digest)).map_err(|e| e.to_string())?;
    Ok(digest)
}

fn described(kind: &str, layout: &Path, digest: &str) -> Result<Value, String> {
    let size = read(&layout.join("blobs/sha256").join(digest))?.len();
    Ok(json!({ "mediaType": kind, "digest": format!("sha256:{digest}"), "size": size }))
}

/// skopeo reads the image as registries and engines do; it checks every digest when it copies.
fn inspect(path: &Path, built: &Built) -> StepResult {
    let image = format!("oci-archive:{}:{}", path.display(), name(built));
    let arch = built.arch.name;
    let mut skopeo = tools::command("skopeo", "skopeo")?;
    let said = output(skopeo.args(["--override-arch", arch, "inspect", "--config", &image]))?;
    let said: Value = serde_json::from_str(&said).map_err(|e| format!("skopeo inspect: {e}"))?;
    if said["config"]["User"] != USER || said["architecture"] != arch {
        return Err(format!("skopeo reads another image: {said}"));
    }
    let copy = work(&format!("image-copy-{arch}"))?.join("copy");
    let to = format!("oci:{}:copy", copy.display());
    output(skopeo_copy(arch)?.args([&image, &to])).map(drop)
}

fn skopeo_copy(arch: &str) -> Result<std::process::Command, String> {
    let mut skopeo = tools::command("skopeo", "skopeo")?;
    skopeo.args(["--insecure-policy", "--override-arch", arch, "copy"]);
    Ok(skopeo)
}

/// Unpacks the layers of an image below a folder, as an engine does.
pub fn unpack(path: &Path, to: &Path) -> StepResult {
    let layout = work("image-unpacked")?;
    output(tools::command("tar", "tar")?.arg("-xf").arg(path).arg("-C").arg(&layout))?;
    let json = |path: PathBuf| -> Result<Value, String> {
        serde_json::from_slice(&read(&path)?).map_err(|e| format!("{}: {e}", path.display()))
    };
    let blob = |digest: &Value| {
        let digest = digest.as_str().unwrap_or_default();
        layout.join("blobs/sha256").join(digest.trim_start_matches("sha256:"))
    };
    let index = json(layout.join("index.json"))?;
    let manifest = json(blob(&index["manifests"][0]["digest"]))?;
    for layer in manifest["layers"].as_array().into_iter().flatten() {
        let mut tar = tools::command("tar", "tar")?;
        output(
            tar.args(["--numeric-owner", "-xzpf"]).arg(blob(&layer["digest"])).arg("-C").arg(to),
        )?;
    }
    Ok(())
}
