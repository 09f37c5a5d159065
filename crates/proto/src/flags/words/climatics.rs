//! §3.3.3 «Флаги состояния Climatics»: the same three things for each heated node.

use super::{Words, words};

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

pub const HORIZONTAL_HEAT: Words = heat([
    "The heating of the traverse drive is on.",
    "Включён подогрев привода горизонтального перемещения.",
]);
pub const VERTICAL_HEAT: Words = heat([
    "The heating of the elevation drive is on.",
    "Включён подогрев привода вертикального перемещения.",
]);
pub const NOZZLE_HEAT: Words =
    heat(["The heating of the nozzle's drive is on.", "Включён подогрев привода насадка."]);
pub const DEPLOYER_HEAT: Words = heat([
    "The heating of the deployment drive is on.",
    "Включён подогрев привода поворотного узла.",
]);
pub const BOX_HEAT: Words = heat([
    "The heating of the housing or cabinet is on.",
    "Включён подогрев внутри корпуса или шкафа управления.",
]);
pub const HORIZONTAL_FAULT: Words = fault([
    "The heating of the traverse drive is faulty.",
    "Неисправен подогрев привода горизонтального перемещения.",
]);
pub const VERTICAL_FAULT: Words = fault([
    "The heating of the elevation drive is faulty.",
    "Неисправен подогрев привода вертикального перемещения.",
]);
pub const NOZZLE_FAULT: Words =
    fault(["The heating of the nozzle's drive is faulty.", "Неисправен подогрев привода насадка."]);
pub const DEPLOYER_FAULT: Words = fault([
    "The heating of the deployment drive is faulty.",
    "Неисправен подогрев привода поворотного узла.",
]);
pub const BOX_FAULT: Words = fault([
    "The heating of the housing or cabinet is faulty.",
    "Неисправен подогрев в корпусе или шкафу управления.",
]);
pub const HORIZONTAL_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the traverse drive is faulty.",
    "Неисправен датчик температуры привода горизонтального перемещения.",
]);
pub const VERTICAL_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the elevation drive is faulty.",
    "Неисправен датчик температуры привода вертикального перемещения.",
]);
pub const NOZZLE_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the nozzle is faulty.",
    "Неисправен датчик температуры насадка.",
]);
pub const DEPLOYER_SENSOR_FAULT: Words = sensor([
    "The temperature sensor of the deployment drive is faulty.",
    "Неисправен датчик температуры поворотного узла.",
]);
pub const BOX_SENSOR_FAULT: Words = sensor([
    "The temperature sensor in the housing or cabinet is faulty.",
    "Неисправен датчик температуры в корпусе или шкафу управления.",
]);
pub const HUMIDITY_SENSOR_FAULT: Words =
    sensor(["The humidity sensor is faulty.", "Неисправен датчик влажности."]);
