//! §3.3.3 «Флаги состояния Climatics»: the same three things for each heated node.

use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// Climate inside the monitor (§3.3, §3.3.3), 16 bytes.
    ThermoStatus [flags: ClimaticsFlags] {
        horizontal i16 DeciCelsius "Temperature of the traverse drive" "Температура привода горизонтального перемещения";
        vertical i16 DeciCelsius "Temperature of the elevation drive" "Температура привода вертикального перемещения";
        nozzle i16 DeciCelsius "Temperature of the nozzle drive" "Температура привода насадка";
        deployer i16 DeciCelsius "Temperature of the deployment drive" "Температура привода развёртывания";
        housing i16 DeciCelsius "Temperature of the housing" "Температура корпуса";
        humidity u16 Percent "Humidity in the housing" "Влажность в корпусе";
    }
}

flag_class! {
    /// §3.3.3 Climatics.
    ClimaticsFlags "3.3.3";
    HORIZONTAL_HEAT = 16 "HorizontalHeat" Info HORIZONTAL_HEAT;
    VERTICAL_HEAT = 17 "VerticalHeat" Info VERTICAL_HEAT;
    NOZZLE_HEAT = 18 "NozzleHeat" Info NOZZLE_HEAT;
    DEPLOYER_HEAT = 19 "DeployerHeat" Info DEPLOYER_HEAT;
    BOX_HEAT = 20 "BoxHeat" Info BOX_HEAT;
    HORIZONTAL_FAULT = 21 "HorizontalFault" Warning HORIZONTAL_FAULT;
    VERTICAL_FAULT = 22 "VerticalFault" Warning VERTICAL_FAULT;
    NOZZLE_FAULT = 23 "NozzleFault" Warning NOZZLE_FAULT;
    DEPLOYER_FAULT = 24 "DeployerFault" Warning DEPLOYER_FAULT;
    BOX_FAULT = 25 "BoxFault" Warning BOX_FAULT;
    HORIZONTAL_SENSOR_FAULT = 26 "HorizontalSensorFault" Warning HORIZONTAL_SENSOR_FAULT;
    VERTICAL_SENSOR_FAULT = 27 "VerticalSensorFault" Warning VERTICAL_SENSOR_FAULT;
    NOZZLE_SENSOR_FAULT = 28 "NozzleSensorFault" Warning NOZZLE_SENSOR_FAULT;
    DEPLOYER_SENSOR_FAULT = 29 "DeployerSensorFault" Warning DEPLOYER_SENSOR_FAULT;
    BOX_SENSOR_FAULT = 30 "BoxSensorFault" Warning BOX_SENSOR_FAULT;
    HUMIDITY_SENSOR_FAULT = 31 "HumiditySensorFault" Warning HUMIDITY_SENSOR_FAULT;
}

const fn heat(meaning: [&'static str; 2]) -> Words {
    words(
        meaning,
        ["The node is colder than HeatOn.", "Узел холоднее HeatOn."],
        [
            "Nothing; heating ends above HeatOff, so that grease stays soft and water does not \
            freeze in the joints.",
            "Ничего; подогрев выключится выше HeatOff, он сохраняет смазку и не даёт воде \
            замёрзнуть в узлах.",
        ],
    )
}

const fn fault(meaning: [&'static str; 2]) -> Words {
    words(
        meaning,
        [
            "The heater is on but draws no current or the node does not get warmer: burnt element, \
            blown fuse, broken wire, stuck relay.",
            "Нагреватель включён, но тока нет или узел не греется: перегорел элемент или \
            предохранитель, обрыв провода, залипло реле.",
        ],
        [
            "Measure the heater's resistance and its fuse; in frost move the node now and then, or \
            drain it, until it is repaired.",
            "Измерьте сопротивление нагревателя и проверьте предохранитель; в мороз до ремонта \
            периодически двигайте узел или слейте воду.",
        ],
    )
}

const fn sensor(meaning: [&'static str; 2]) -> Words {
    words(
        meaning,
        [
            "The reading is missing or impossible: broken wire, wet connector, dead sensor.",
            "Показаний нет или они невозможны: обрыв провода, влага в разъёме, отказ датчика.",
        ],
        [
            "Check the connector and the line, replace the sensor; the value in the status is not \
            to be trusted meanwhile.",
            "Проверьте разъём и линию, замените датчик; до этого значению в состоянии верить \
            нельзя.",
        ],
    )
}

const HORIZONTAL_HEAT: Words = heat([
    "The heating of the traverse drive is on.",
    "Включён подогрев привода горизонтального перемещения.",
]);
const VERTICAL_HEAT: Words = heat([
    "The heating of the elevation drive is on.",
    "Включён подогрев привода вертикального перемещения.",
]);
const NOZZLE_HEAT: Words =
    heat(["The heating of the nozzle's drive is on.", "Включён подогрев привода насадка."]);
const DEPLOYER_HEAT: Words = heat([
    "The heating of the deployment drive is on.",
    "Включён подогрев привода поворотного узла.",
]);
const BOX_HEAT: Words = heat([
    "The heating of the housing or cabinet is on.",
    "Включён подогрев внутри корпуса или шкафа управления.",
]);
const HORIZONTAL_FAULT: Words = fault([
    "The heating of the traverse drive is faulty.",
    "Неисправен подогрев привода горизонтального перемещения.",
]);
const VERTICAL_FAULT: Words = fault([
    "The heating of the elevation drive is faulty.",
    "Неисправен подогрев привода вертикального перемещения.",
]);
const NOZZLE_FAULT: Words =
    fault(["The heating of the nozzle's drive is faulty.", "Неисправен подогрев привода насадка."]);
const DEPLOYER_FAULT: Words = fault([
    "The heating of the deployment drive is faulty.",
    "Неисправен подогрев привода поворотного узла.",
]);
const BOX_FAULT: Words = fault([
    "The heating of the housing or cabinet is faulty.",
    "Неисправен подогрев в корпусе или шкафу управления.",
]);
const HORIZONTAL_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the traverse drive is faulty.",
    "Неисправен датчик температуры привода горизонтального перемещения.",
]);
const VERTICAL_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the elevation drive is faulty.",
    "Неисправен датчик температуры привода вертикального перемещения.",
]);
const NOZZLE_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the nozzle is faulty.",
    "Неисправен датчик температуры насадка.",
]);
const DEPLOYER_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the deployment drive is faulty.",
    "Неисправен датчик температуры поворотного узла.",
]);
const BOX_SENSOR_FAULT: Words = sensor([
    "The temperature sensor in the housing or cabinet is faulty.",
    "Неисправен датчик температуры в корпусе или шкафу управления.",
]);
const HUMIDITY_SENSOR_FAULT: Words =
    sensor(["The humidity sensor is faulty.", "Неисправен датчик влажности."]);
