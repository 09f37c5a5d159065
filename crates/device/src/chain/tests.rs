//! Who may be asked, from names.

use super::*;

/// §3 «Адресаты»: the ones that are named, and no others.
#[test]
fn only_those_named() {
    let named = only(&[SubsystemId::DEPLOYER, SubsystemId::VALVE2]);
    assert_eq!(named.subsystems.bits(), 1 << 9 | 1 << 6, "entries of the table of §1");
    let (all, motors) = (named.and_all(), named.and_motors());
    let broadcasts = [named, all, motors].map(|who| (who.all, who.motors));
    assert_eq!(broadcasts, [(false, false), (true, false), (false, true)]);
    assert_eq!([all.subsystems, motors.subsystems], [named.subsystems; 2]);
}
