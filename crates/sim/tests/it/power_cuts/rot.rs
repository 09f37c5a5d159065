//! Damage of the chip itself: flipped bits, pages full of anything, a chip that was never written.

use lafet_proto::flags::CommonFlags;
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};
use lafet_sim::flash::{Chip, Flash, PAGE, PAGES};
use lafet_sim::rng::Rng;
use lafet_sim::sim::{Config, Sim};

use super::held::{ask, is_locked, monitor, set, settle};

/// A value that was never set, and that is no default.
const SPEED: i32 = 9;

fn locked_out() -> Sim {
    let mut sim = monitor(4);
    set(&mut sim, Param::VerticalSpeed, &[SPEED]);
    settle(&mut sim);
    set(&mut sim, Param::ControlProgram2, &[5; 7]);
    settle(&mut sim);
    ask(&mut sim, SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
    settle(&mut sim);
    sim
}

/// §3.18/6, §3.3.1/1 One flipped bit, wherever: still locked out, and each value is the old one or
/// reported as damaged.
#[test]
fn a_flipped_bit() {
    let mut sim = locked_out();
    let mut faults = 0;
    for bit in (0..PAGE * PAGES * 8).step_by(3) {
        sim.world_mut().flash.chip_mut().flip(bit / 8, (bit % 8) as u8);
        let mut damaged = sim.clone();
        sim.world_mut().flash.chip_mut().flip(bit / 8, (bit % 8) as u8);
        damaged.power_cycle();
        assert!(is_locked(&mut damaged), "bit {bit}");
        let params = damaged.device().params();
        let broken: Vec<_> =
            SubsystemId::TABLE.into_iter().filter(|id| params.has_read_fault(*id)).collect();
        assert!(broken.len() <= 1, "bit {bit}: {broken:?}");
        faults += broken.len();
        if !broken.contains(&SubsystemId::VERTICAL) {
            assert_eq!(params.get(Param::VerticalSpeed), SPEED, "bit {bit}");
        }
        if !broken.contains(&SubsystemId::CONTROL) {
            assert_eq!(params.program(2), Some([5; 7]), "bit {bit}");
        }
    }
    assert!(faults > 500, "{faults}");
}

/// Pages lost or full of anything: the start succeeds, every frame is answered, and after CleanFlash
/// the monitor can be configured.
#[test]
fn a_damaged_chip() {
    let mut rng = Rng::new(8);
    let locked = locked_out();
    let mut kept = 0;
    for case in 0..300 {
        let mut sim = locked.clone();
        let erased = rng.bits() & 1 == 0;
        for page in 0..PAGES {
            if rng.bits() & 1 == 0 {
                continue;
            }
            let chip = sim.world_mut().flash.chip_mut();
            for address in page * PAGE..(page + 1) * PAGE {
                let byte = if erased { 0xFF } else { rng.bits() as u8 };
                let flipped = chip.bytes()[address] ^ byte;
                for bit in (0..8).filter(|bit| flipped >> bit & 1 != 0) {
                    chip.flip(address, bit);
                }
            }
        }
        sim.power_cycle();
        kept += u32::from(is_locked(&mut sim));
        assert_eq!(ask(&mut sim, SubsystemId::GENERAL, Body::GetStatus), Status::OK, "case {case}");
        ask(&mut sim, SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
        sim.advance_ms(200);
        ask(&mut sim, SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH });
        sim.advance_ms(1000);
        assert_eq!(sim.resets(), 1, "case {case}");
        set(&mut sim, Param::RadioTimeout, &[4000]);
        sim.advance_ms(200);
        assert_eq!(set(&mut sim, Param::RadioTimeout, &[4000]), Status::OK, "case {case}");
        sim.power_cycle();
        assert_eq!(sim.device().params().get(Param::RadioTimeout), 4000, "case {case}");
        assert!(!is_locked(&mut sim), "case {case}");
    }
    assert!(kept > 100, "{kept}");
}

/// A board that was never provisioned: ConfigInvalid, not ConfigFault, and not locked out.
#[test]
fn a_new_chip() {
    let flash = Flash::from_bytes(&Flash::new(1).to_bytes()).unwrap();
    assert_eq!(flash.chip().bytes(), Chip::new(1).bytes());
    let mut sim = Sim::new(Config { flash: Some(flash), ..Config::default() });
    assert!(!is_locked(&mut sim));
    let mut flags = 0;
    sim.ask(SubsystemId::VERTICAL, Body::GetStatus, |answer| {
        flags = answer.data.flags_bits().unwrap();
    });
    assert_eq!(CommonFlags::from_bits_truncate(flags), CommonFlags::CONFIG_INVALID);
}
