//! The faults that can be injected, with their texts.

use lafet_hub::simulation;
use lafet_hub::text::{Both, both};
use lafet_sim::fault::{
    ButtonFault, DriveFault, Fault, SingleFault, UnitFault, ValveFault, axis_name, place_name,
    unit_name, valve_name,
};

type Words = (&'static str, &'static str);

/// All faults: name, group and text.
pub fn catalogue() -> Vec<simulation::Fault> {
    let one = |fault: Fault| {
        let group = group(fault);
        let (en, ru) = group_words(group);
        let group_text = both(en, ru);
        simulation::Fault { name: fault.name(), group, group_text, text: words(fault) }
    };
    Fault::all().map(one).collect()
}

/// Name of the part of the monitor that a fault belongs to.
fn group(fault: Fault) -> &'static str {
    match fault {
        Fault::Drive(axis, _) => axis_name(axis),
        Fault::Valve(valve, _) => valve_name(valve),
        Fault::Temperature(place)
        | Fault::TemperatureFrozen(place)
        | Fault::TemperatureDrift(place)
        | Fault::Heater(place) => place_name(place),
        Fault::Unit(unit, _) => unit_name(unit),
        Fault::Button(post, ..) => post.name(),
        Fault::Single(fault) => match fault {
            SingleFault::PressureBreak
            | SingleFault::PressureShort
            | SingleFault::PressureFrozen
            | SingleFault::PressureDrift
            | SingleFault::FlowFrozen
            | SingleFault::FlowDrift
            | SingleFault::PumpOff
            | SingleFault::PumpWeak => "water",
            SingleFault::DetectorDead | SingleFault::DetectorSaturated | SingleFault::DirtyLens => {
                "detector"
            }
            SingleFault::Humidity => "box",
            _ => "general",
        },
    }
}

fn group_words(group: &str) -> Words {
    match group {
        "vertical" => ("Elevation drive", "Привод вертикали"),
        "horizontal" => ("Azimuth drive", "Привод горизонтали"),
        "nozzle" => ("Nozzle", "Насадок"),
        "deployer" => ("Deployer", "Механизм развёртывания"),
        "valve1" => ("Valve 1", "Затвор 1"),
        "valve2" => ("Valve 2", "Затвор 2"),
        "box" => ("Control box", "Блок управления"),
        "buttons" => ("Button post", "Кнопочный пост"),
        "ext-buttons" => ("Remote button post", "Выносной кнопочный пост"),
        "water" => ("Water", "Вода"),
        "detector" => ("Detector", "Извещатель"),
        _ => ("Monitor", "Ствол"),
    }
}

fn words(fault: Fault) -> Both {
    match fault {
        Fault::Drive(_, fault) => of(drive(fault)),
        Fault::Valve(_, fault) => of(valve(fault)),
        Fault::Temperature(_) => {
            of(("Temperature sensor does not answer", "Датчик температуры не отвечает"))
        }
        Fault::TemperatureFrozen(_) => {
            of(("Temperature reading does not change", "Показание температуры не меняется"))
        }
        Fault::TemperatureDrift(_) => of((
            "Temperature reading drifts up, 0.1 °C a second",
            "Показание температуры уходит вверх, 0,1 °C в секунду",
        )),
        Fault::Heater(_) => of(("Heater's circuit is broken", "Обрыв цепи обогревателя")),
        Fault::Unit(_, fault) => of(unit(fault)),
        Fault::Button(_, button, fault) => {
            let (en, ru) = match fault {
                ButtonFault::Short => ("short circuit", "короткое замыкание"),
                ButtonFault::Break => ("broken wire", "обрыв"),
            };
            both(format!("Button {button:?}: {en}"), format!("Кнопка {button:?}: {ru}"))
        }
        Fault::Single(fault) => of(single(fault)),
    }
}

fn of((en, ru): Words) -> Both {
    both(en, ru)
}

const fn drive(fault: DriveFault) -> Words {
    match fault {
        DriveFault::MotorOpen => ("Motor circuit is broken", "Обрыв цепи двигателя"),
        DriveFault::Jam => ("Jammed: does not move", "Заклинило: не движется"),
        DriveFault::PowerStage => {
            ("Power stage is dead, undiagnosed", "Силовой каскад мёртв, диагностики нет")
        }
        DriveFault::Runaway => (
            "Power stage is shorted: runs by itself",
            "Силовой каскад пробит: движется без команды",
        ),
        DriveFault::Friction => ("Friction: draws too much", "Трение: ток выше допустимого"),
        DriveFault::Flicker => {
            ("Friction, and a current reading with gaps", "Трение, показание тока с пропусками")
        }
        DriveFault::Lag => ("Speed follows late, 300 ms", "Скорость запаздывает, 300 мс"),
        DriveFault::DeadBand => {
            ("Does not turn below 1 °/s or 1 mm/s", "Не движется медленнее 1 °/с или 1 мм/с")
        }
        DriveFault::Droop => (
            "Speed yields to the load, 0.4 °/s for each A",
            "Скорость падает под нагрузкой, 0,4 °/с на 1 А",
        ),
        DriveFault::Backlash => ("Play of 12′ or 1 mm in the gear", "Люфт редуктора 12′ или 1 мм"),
        DriveFault::Stiff => ("Stiff grease: draws more", "Густая смазка: ток повышен"),
        DriveFault::EncoderDead => ("Position reading does not change", "Положение не меняется"),
        DriveFault::EncoderReversed => {
            ("Position counts the wrong way", "Положение считается наоборот")
        }
        DriveFault::EncoderFast => {
            ("Position counts four times too much", "Положение считается вчетверо быстрее")
        }
        DriveFault::EncoderJump => {
            ("Position has jumped by 20° or 15 mm", "Положение скачком изменилось на 20° или 15 мм")
        }
        DriveFault::EncoderNoise => {
            ("Position is noisy, ±2′ or ±1 mm", "Шум датчика положения, ±2′ или ±1 мм")
        }
        DriveFault::EncoderFault => {
            ("Position sensor reports a fault", "Датчик положения сообщает о неисправности")
        }
        DriveFault::SpeedDead => ("Speed sensor reads zero", "Датчик скорости показывает ноль"),
        DriveFault::SpeedReversed => {
            ("Speed sensor has the wrong sign", "Датчик скорости с обратным знаком")
        }
        DriveFault::SpeedFault => {
            ("Speed sensor reports a fault", "Датчик скорости сообщает о неисправности")
        }
        DriveFault::MinSwitch => {
            ("Lower, right or stowed end switch stuck on", "Залип концевой выключатель min")
        }
        DriveFault::MaxSwitch => {
            ("Upper, left or deployed end switch stuck on", "Залип концевой выключатель max")
        }
        DriveFault::MinBounce => (
            "Lower, right or stowed end switch bounces and blips",
            "Дребезг концевого выключателя min",
        ),
        DriveFault::MaxBounce => (
            "Upper, left or deployed end switch bounces and blips",
            "Дребезг концевого выключателя max",
        ),
    }
}

const fn valve(fault: ValveFault) -> Words {
    match fault {
        ValveFault::MotorOpen => ("Motor circuit is broken", "Обрыв цепи двигателя"),
        ValveFault::OpenRelay => {
            ("Relay is welded: opens by itself", "Реле приварилось: открывается само")
        }
        ValveFault::Jam => ("Plug is stuck", "Заклинило"),
        ValveFault::OpenSwitch => {
            ("Circuit of the switch «open» is broken", "Неисправна цепь датчика «открыт»")
        }
        ValveFault::CloseSwitch => {
            ("Circuit of the switch «closed» is broken", "Неисправна цепь датчика «закрыт»")
        }
        ValveFault::CloseStuck => {
            ("Switch «closed» is stuck on", "Залип концевой выключатель «закрыт»")
        }
        ValveFault::Blocked => ("Hardware block is on", "Включена аппаратная блокировка"),
        ValveFault::OpenBounce => {
            ("Switch «open» bounces and blips", "Дребезг концевого выключателя «открыт»")
        }
        ValveFault::CloseBounce => {
            ("Switch «closed» bounces and blips", "Дребезг концевого выключателя «закрыт»")
        }
        ValveFault::BlockedBounce => {
            ("Contact of the hardware block bounces", "Дребезг контакта аппаратной блокировки")
        }
    }
}

const fn unit(fault: UnitFault) -> Words {
    match fault {
        UnitFault::Offline => ("Remote unit does not answer", "Удалённый модуль не отвечает"),
        UnitFault::Lossy => {
            ("Remote unit: half of the exchanges are lost", "Удалённый модуль: теряется половина")
        }
        UnitFault::Protocol => {
            ("Remote unit breaks its protocol", "Удалённый модуль нарушает протокол")
        }
        UnitFault::Watchdog => {
            ("Remote unit was reset by its watchdog", "Удалённый модуль перезапущен таймером")
        }
        UnitFault::ParamSilent => {
            ("Remote parameters: no answer", "Удалённые параметры: нет ответа")
        }
        UnitFault::ParamIncomplete => {
            ("Remote parameters: incomplete", "Удалённые параметры: неполный обмен")
        }
        UnitFault::ParamBadId => ("Remote parameters: bad id", "Удалённые параметры: неверный id"),
        UnitFault::ParamBadValue => {
            ("Remote parameters: bad value", "Удалённые параметры: неверное значение")
        }
        UnitFault::ParamError => ("Remote parameters: error", "Удалённые параметры: ошибка"),
    }
}

const fn single(fault: SingleFault) -> Words {
    match fault {
        SingleFault::PressureBreak => ("Pressure sensor: broken wire", "Датчик давления: обрыв"),
        SingleFault::PressureShort => {
            ("Pressure sensor: short circuit", "Датчик давления: замыкание")
        }
        SingleFault::PressureFrozen => {
            ("Pressure reading does not change", "Показание давления не меняется")
        }
        SingleFault::PressureDrift => (
            "Pressure sensor drifts down, 20 µA a second",
            "Датчик давления уходит вниз, 20 мкА в секунду",
        ),
        SingleFault::FlowFrozen => {
            ("Flow reading does not change", "Показание расхода не меняется")
        }
        SingleFault::FlowDrift => (
            "Flow meter drifts up, 1 l/s in five seconds",
            "Расходомер уходит вверх, 1 л/с за пять секунд",
        ),
        SingleFault::PumpOff => ("The pump gives nothing", "Насос не работает"),
        SingleFault::PumpWeak => {
            ("The pump gives a quarter of its pressure", "Насос даёт четверть давления")
        }
        SingleFault::VoltageLow => ("Supply voltage a third too low", "Питание ниже на треть"),
        SingleFault::VoltageHigh => ("Supply voltage a third too high", "Питание выше на треть"),
        SingleFault::SupplyDip => {
            ("Supply dips for 0.2 s when a motor starts", "Провал питания 0,2 с при пуске привода")
        }
        SingleFault::SupplySag => {
            ("Supply sags as long as a motor runs", "Просадка питания, пока работает двигатель")
        }
        SingleFault::Humidity => {
            ("Humidity sensor does not answer", "Датчик влажности не отвечает")
        }
        SingleFault::DetectorDead => ("Detector does not answer", "Извещатель не отвечает"),
        SingleFault::DetectorSaturated => {
            ("Detector is saturated: light everywhere", "Извещатель засвечен по всему полю")
        }
        SingleFault::DirtyLens => ("Detector's glass is dirty", "Загрязнено стекло извещателя"),
        SingleFault::FlashRead => ("Memory cannot be read", "Память не читается"),
        SingleFault::FlashWrite => ("Memory cannot be written", "Память не записывается"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_its_words_once() {
        let all = catalogue();
        assert_eq!(all.len(), Fault::all().count());
        let mut words: Vec<(&str, &str)> = all.iter().map(|it| (it.group, &*it.text.ru)).collect();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), all.len(), "two faults of a part have the same words");
    }
}
