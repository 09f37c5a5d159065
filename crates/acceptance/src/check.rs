//! The checks: each with the requirement that it is for, its source, and the step in which it is tried.

use lafet_texts::{Fixed, acceptance as text};

/// A step. A later one does what none before it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Nothing is ordered.
    Read,
    /// Barrels turn, one at a time.
    Dry,
    /// People try detectors, pumps and the test outlet of a zone; nothing is ordered.
    Outlet,
}

impl Stage {
    /// In order.
    pub const ALL: [Self; 3] = [Self::Read, Self::Dry, Self::Outlet];

    /// Those that are tried unless others are asked for: the rest needs people at the installation.
    pub const USUAL: [Self; 2] = [Self::Read, Self::Dry];

    /// Its name on the command line and in the record.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Dry => "dry",
            Self::Outlet => "outlet",
        }
    }

    /// Its name for people.
    pub const fn title(self) -> Fixed {
        match self {
            Self::Read => text::StageRead.fixed(),
            Self::Dry => text::StageDry.fixed(),
            Self::Outlet => text::StageOutlet.fixed(),
        }
    }
}

/// A check.
#[derive(Clone, Copy, Debug)]
pub struct Check {
    /// Its id: stable, for programs and people.
    pub id: &'static str,
    /// The step in which it is tried.
    pub stage: Stage,
    /// The requirement of docs/installation.md; empty: none of them.
    pub requirement: &'static str,
    /// Where the requirement was found; empty: ours.
    pub source: &'static str,
    /// What is checked.
    pub title: Fixed,
}

macro_rules! checks {
    ($($stage:ident $name:ident $id:literal $requirement:literal $source:literal $title:expr;)*) => {
        $(
            #[doc = concat!("`", $id, "`")]
            pub const $name: Check = Check {
                id: $id,
                stage: Stage::$stage,
                requirement: $requirement,
                source: $source,
                title: $title.fixed(),
            };
        )*

        /// All checks, in the order of the record.
        pub const ALL: &[Check] = &[$($name),*];
    };
}

checks! {
    Read STORAGE "storage" "" "" text::TitleStorage;
    Read DISK "disk" "I-50" "GB 25506 §6" text::TitleDisk;
    Read AUDIT_CHAIN "audit-chain" "I-50" "GB 25506 §6" text::TitleAuditChain;
    Read CLOCK "clock" "I-10" "GB 50166 §4.1.3" text::TitleClock;
    Read LOGIN "login" "" "" text::TitleLogin;
    Read MONITORS_KNOWN "monitors-known" "" "" text::TitleMonitorsKnown;
    Read LINK "link" "I-40" "NFPA 72" text::TitleLink;
    Read READY "ready" "" "" text::TitleReady;
    Read REST "rest" "" "" text::TitleRest;
    Read PRESSURE_AT_REST "pressure-at-rest" "" "" text::TitlePressureAtRest;
    Read FREE "free" "" "" text::TitleFree;
    Read WATER_TIMEOUT "water-timeout" "" "" text::TitleWaterTimeout;
    Read PARAMETERS "parameters" "" "" text::TitleParameters;
    Read PLACE "place" "" "" text::TitlePlace;
    Read KEEP_OUTS "keep-outs" "" "" text::TitleKeepOuts;
    Read MODE "mode" "I-32" "IMO §4.4" text::TitleMode;
    Read DISABLED "disabled" "I-06" "EN 54-2 §9.4.2c" text::TitleDisabled;
    Read TROUBLES "troubles" "I-40" "NFPA 72" text::TitleTroubles;
    Read ABLE "able" "I-05" "FV300; Net Safety" text::TitleAble;
    Read QUIET "quiet" "" "" text::TitleQuiet;
    Read TWO_SIGNALS "two-signals" "I-01" "UFGS-13956N; GB 50284 §8.4.5" text::TitleTwoSignals;
    Read VOTES "votes" "I-01" "UFGS-13956N; GB 50116 §4.1.6" text::TitleVotes;
    Read COINCIDENCE "coincidence" "I-02" "UFGS-13956N" text::TitleCoincidence;
    Read DELAY "delay" "I-15" "EN 12094-1 §4.17, 4.20" text::TitleDelay;
    Read SERVED "served" "I-20" "GB 50338" text::TitleServed;
    Read DETECTORS "detectors" "" "" text::TitleDetectors;
    Read WHEN_FAILED "when-failed" "I-05" "FV300; Net Safety" text::TitleWhenFailed;
    Read WATER_MAX "water-max" "" "" text::TitleWaterMax;
    Read RETURNS "returns" "I-32" "IMO §4.4" text::TitleReturns;
    Read AIMS "aims" "" "" text::TitleAims;
    Read SILENCE "silence" "I-05" "FV300; Net Safety" text::TitleSilence;
    Read DETECTOR_PLACE "detector-place" "" "" text::TitleDetectorPlace;
    Read BUSES "buses" "I-40" "NFPA 72" text::TitleBuses;
    Read PUMPS_REST "pumps-rest" "" "" text::TitlePumpsRest;
    Read CONTACTS "contacts" "" "" text::TitleContacts;
    Read OUTPUTS "outputs" "" "" text::TitleOutputs;
    Read PUMPS "pumps" "I-35" "GB 50284 §8.4.3" text::TitlePumps;
    Read ALARMS "alarms" "" "" text::TitleAlarms;
    Dry MOTION "motion" "I-44" "" text::TitleMotion;
    Dry WHICH "which" "" "" text::TitleWhich;
    Dry HEADING "heading" "" "" text::TitleHeading;
    Dry STOP "stop" "I-31" "IMO §4.4" text::TitleStop;
    Dry CLOSED "closed" "" "" text::TitleClosed;
    Outlet RESPONDS "responds" "I-04" "GB 50166 §4.3.12" text::TitleResponds;
    Outlet ALONE "alone" "" "" text::TitleAlone;
    Outlet BEARING "bearing" "" "" text::TitleBearing;
    Outlet ONE_SIGNAL "one-signal" "I-01" "UFGS-13956N; GB 50284 §8.4.5" text::TitleOneSignal;
    Outlet RELEASE "release" "I-10" "GB 50166 §4.1.3" text::TitleRelease;
    Outlet PUMP_ORDER "pump-order" "I-35" "GB 50284 §8.4.3" text::TitlePumpOrder;
    Outlet PUMP_RUNS "pump-runs" "I-35" "GB 50284 §8.4.3" text::TitlePumpRuns;
    Outlet OUTLET "outlet" "I-43" "GB 51427 §4.3.11" text::TitleOutlet;
    Outlet OUTLET_WATER "outlet-water" "I-43" "GB 51427 §4.3.11" text::TitleOutletWater;
    Outlet OUTLET_PRESSURE "outlet-pressure" "I-43" "GB 51427 §4.3.11" text::TitleOutletPressure;
    Outlet NO_WATER "no-water" "I-43" "GB 51427 §4.3.11" text::TitleNoWater;
    Outlet ABORT "abort" "I-31" "IMO §4.4" text::TitleAbort;
    Outlet BACK "back" "" "" text::TitleBack;
}

/// A check by its id.
pub fn by_id(id: &str) -> Option<&'static Check> {
    ALL.iter().find(|it| it.id == id)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_unique_and_stages_in_order() {
        for (index, check) in ALL.iter().enumerate() {
            let same = ALL.iter().filter(|it| it.id == check.id).count();
            assert_eq!(same, 1, "{}", check.id);
            let after = ALL.get(index + 1).is_none_or(|next| next.stage >= check.stage);
            assert!(after, "{} comes after a later step", check.id);
        }
        assert_eq!(by_id("link").map(|it| it.requirement), Some("I-40"));
        assert!(by_id("").is_none());
    }
}
