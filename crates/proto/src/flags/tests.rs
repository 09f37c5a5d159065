use super::*;
use std::collections::BTreeSet;
use std::string::{String, ToString};
use std::vec::Vec;

fn check(class: &FlagClass, constants: &[(&str, u32)]) {
    assert_eq!(class.flags.len(), constants.len());
    let mut seen = 0;
    for (info, (constant, bits)) in class.flags.iter().zip(constants) {
        let squeezed: String = constant.chars().filter(|c| *c != '_').collect();
        assert!(squeezed.eq_ignore_ascii_case(info.name), "{constant} is not {}", info.name);
        assert_eq!(info.mask(), *bits, "{constant}");
        assert_eq!(seen & bits, 0, "{constant} overlaps");
        seen |= bits;
        assert_eq!(class.by_name(&info.name.to_lowercase()), Some(info));
    }
    assert_eq!(class.unnamed(!0), !seen);
    assert!(class.flags.is_sorted_by_key(|info| info.shift));
}

#[test]
fn constants_and_dictionary_agree() {
    check(&CommonFlags::CLASS, CommonFlags::CONSTANTS);
    check(&GeneralFlags::CLASS, GeneralFlags::CONSTANTS);
    check(&ClimaticsFlags::CLASS, ClimaticsFlags::CONSTANTS);
    check(&DriveFlags::CLASS, DriveFlags::CONSTANTS);
    check(&ValveFlags::CLASS, ValveFlags::CONSTANTS);
    check(&ControlFlags::CLASS, ControlFlags::CONSTANTS);
    check(&DetectorFlags::CLASS, DetectorFlags::CONSTANTS);
    check(&DeployerFlags::CLASS, DeployerFlags::CONSTANTS);
    check(&ConnFlags::CLASS, ConnFlags::CONSTANTS);
    check(&ButtonsFlags::CLASS, ButtonsFlags::CONSTANTS);
}

/// §3.3.1–§3.3.10: how many flags of its own each class has.
#[test]
fn every_table_of_the_document_is_complete() {
    let own = |id| flags_of(id).flags.len() - 16;
    assert_eq!(CommonFlags::CLASS.flags.len(), 16);
    assert_eq!(SubsystemId::TABLE.map(own), [3, 16, 14, 14, 14, 8, 8, 9, 8, 16, 0, 0, 8, 8]);
    assert_eq!(flags_of(SubsystemId::ALL), &CommonFlags::CLASS);
    assert_eq!(flags_of(SubsystemId(0x77)), &CommonFlags::CLASS);
}

#[test]
fn every_flag_has_a_text_of_its_own() {
    for id in SubsystemId::TABLE {
        let mut meanings = BTreeSet::new();
        for info in flags_of(id).flags {
            assert!(meanings.insert(info.meaning.name()), "two flags say the same: {}", info.name);
        }
    }
}

#[test]
fn names_of_what_is_set() {
    let bits = DeployerFlags::WRAPPED | DeployerFlags::BAD_POWER;
    let names: Vec<String> =
        set_flags(SubsystemId::DEPLOYER, bits.bits()).map(|flag| flag.to_string()).collect();
    assert_eq!(names, ["BadPower", "Wrapped"]);
    assert_eq!(flags_of(SubsystemId::DEPLOYER).severity(bits.bits()), Severity::Alarm);
    assert_eq!(flags_of(SubsystemId::GENERAL).unnamed(0xFFF8_0001), 0xFFF8_0000);
    assert_eq!(flags_of(SubsystemId::GENERAL).severity(0xFFF8_0000), Severity::Info);
}

/// §3.3.9: the same bit is a fault of a drive and ordinary on an idle interface.
#[test]
fn conn_lost_of_an_interface_is_a_notice() {
    let bits = CommonFlags::CONN_LOST.bits();
    assert_eq!(flags_of(SubsystemId::RADIO).severity(bits), Severity::Notice);
    assert_eq!(flags_of(SubsystemId::VERTICAL).severity(bits), Severity::Alarm);
}

/// §3.3.10: two bits a button.
#[test]
fn buttons() {
    let mut flags = ButtonsFlags::empty();
    for (index, button) in Button::ALL.into_iter().enumerate() {
        flags = flags.with_button(button, ButtonState::of(index as u32));
    }
    assert_eq!(flags.bits() >> 16, 0b11_10_01_00_11_10_01_00);
    for (index, button) in Button::ALL.into_iter().enumerate() {
        assert_eq!(flags.button(button), ButtonState::of(index as u32));
    }
    let flags = flags.with_button(Button::Left, ButtonState::Pressed) | ButtonsFlags::DISABLED;
    let names: Vec<String> =
        set_flags(SubsystemId::BUTTONS, flags.bits()).map(|flag| flag.to_string()).collect();
    assert_eq!(
        names,
        [
            "Disabled",
            "LeftButtonState=Pressed",
            "RightButtonState=Pressed",
            "UpButtonState=Short",
            "DownButtonState=Open",
            "NarrowButtonState=Pressed",
            "OpenButtonState=Short",
            "CloseButtonState=Open",
        ]
    );
    let class = flags_of(SubsystemId::BUTTONS);
    let pressed = ButtonsFlags::empty().with_button(Button::Up, ButtonState::Pressed);
    let short = pressed.with_button(Button::Up, ButtonState::Short);
    assert_eq!(class.severity(pressed.bits()), Severity::Info);
    assert_eq!(class.severity(short.bits()), Severity::Warning);
}

/// Bits without a name are kept.
#[test]
fn unknown_bits_are_kept() {
    assert_eq!(ValveFlags::from_bits_retain(0xFF00_0000).bits(), 0xFF00_0000);
    assert_eq!(ValveFlags::from_bits_truncate(0xFF00_0000).bits(), 0xFF00_0000);
}
