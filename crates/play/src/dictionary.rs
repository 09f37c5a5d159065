//! What the page lists: requests, subsystems, faults, profiles, examples.

use lafet_device::Composition;
use lafet_proto::dictionary::{REQUESTS, SUBSYSTEMS};
use lafet_proto::id::RequestId;
use lafet_proto::param::Param;
use lafet_sim::fault::Fault;
use lafet_texts::Text as _;

use crate::examples::EXAMPLES;
use crate::fault::fault_words;
use crate::view::{Description, ExampleInfo, FaultInfo, RequestInfo, SubsystemInfo};

/// Services of a bus controller: a monitor is not asked for them.
const OF_THE_BUS: [RequestId; 3] =
    [RequestId::ACCESS_GRANTED, RequestId::GET_NETWORK_STATUS, RequestId::GET_LOG];

impl Description {
    /// All of it.
    pub fn new() -> Self {
        let requests = REQUESTS.iter().filter(|info| !OF_THE_BUS.contains(&info.id));
        let requests = requests.map(|info| RequestInfo {
            name: info.name.to_owned(),
            section: info.section.to_owned(),
            title: info.title.words(),
            meaning: info.meaning.words(),
            addressees: info.addressees.iter().map(ToString::to_string).collect(),
        });
        let subsystems = SUBSYSTEMS.iter().map(|info| SubsystemInfo {
            name: info.name.to_owned(),
            title: info.title.words(),
            parameters: Param::of(info.id).map(|param| param.name().to_owned()).collect(),
        });
        let faults = Fault::all().map(|it| FaultInfo { name: it.name(), words: fault_words(it) });
        let examples = EXAMPLES.iter().map(|example| ExampleInfo {
            key: example.key.to_owned(),
            fragment: example.session().fragment(),
        });
        Self {
            requests: requests.collect(),
            subsystems: subsystems.collect(),
            faults: faults.collect(),
            profiles: Composition::ALL.iter().map(|it| it.name.to_owned()).collect(),
            examples: examples.collect(),
        }
    }
}
