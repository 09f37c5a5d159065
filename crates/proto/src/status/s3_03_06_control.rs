//! §3.3.6 «Флаги состояния Control» with its notes 1–5 on trajectories.

use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// State of Control (§3.3, §3.3.6), 4 bytes.
    ControlStatus [flags: ControlFlags] {}
}

flag_class! {
    /// §3.3.6 Control.
    ControlFlags "3.3.6";
    QUENCH = 16 "Quench" Info QUENCH;
    OUTSIDE_LIMITS = 17 "OutsideLimits" Warning OUTSIDE_LIMITS;
    MODE_FAULT = 18 "ModeFault" Warning MODE_FAULT;
    PAUSED = 19 "Paused" Notice PAUSED;
    TRAJECTORY_PRESSURE_FAULT = 20 "TrajectoryPressureFault" Warning
        TRAJECTORY_PRESSURE_FAULT;
    TRAJECTORY_RANGE_FAULT = 21 "TrajectoryRangeFault" Warning TRAJECTORY_RANGE_FAULT;
    TRAJECTORY_ANGLE_FAULT = 22 "TrajectoryAngleFault" Warning TRAJECTORY_ANGLE_FAULT;
    TRAJECTORY_CRC_FAULT = 23 "TrajectoryCRCFault" Warning TRAJECTORY_CRC_FAULT;
    TRAJECTORY = 24 "Trajectory" Info TRAJECTORY;
}

const QUENCH: Words = words(
    ["A program of extinguishing is running.", "Выполняется программа тушения."],
    ["StartQuench or StartTrajectory was accepted.", "Принят StartQuench или StartTrajectory."],
    [
        "Nothing; Move corrects the aim, Stop Control ends it and leaves the valves as they are.",
        "Ничего; Move корректирует наводку, Stop Control завершает и не трогает затворы.",
    ],
);
const OUTSIDE_LIMITS: Words = words(
    [
        "The sector is wholly or partly outside the limits of travel.",
        "Сектор тушения полностью или частично вне пределов.",
    ],
    [
        "The centre or size was given wrong, the limits are narrower than the task, or the \
        corrected elevation is above the upper limit.",
        "Неверно задан центр или размер, пределы уже задачи либо угол с поправкой выше верхнего \
        предела.",
    ],
    [
        "Compare the sector with RetrieveLimits; the part inside is extinguished, cover the rest \
        with another monitor.",
        "Сравните сектор с RetrieveLimits; часть внутри пределов тушится, остальное закройте \
        другим стволом.",
    ],
);
const MODE_FAULT: Words = words(
    [
        "The program cannot run in the present state of the monitor.",
        "Программа тушения не может выполняться в текущем состоянии ствола.",
    ],
    [
        "The whole sector is out of reach, deployment failed, a drive is faulty, or limits are \
        switched off.",
        "Весь сектор недостижим, не удалось развёртывание, неисправен привод или выключены \
        пределы.",
    ],
    [
        "Look at the flags of Deployer, Vertical, Horizontal and Nozzle, clear the cause and start \
        again.",
        "Посмотрите флаги Deployer, Vertical, Horizontal и Nozzle, устраните причину и запустите \
        снова.",
    ],
);
const PAUSED: Words = words(
    [
        "The program waits while the operator corrects the aim.",
        "Программа приостановлена для корректировки оператором.",
    ],
    ["Move was sent to a drive during extinguishing.", "Во время тушения приводу отправлен Move."],
    [
        "Nothing; 3 s after the last Move it goes on around the point reached.",
        "Ничего; через 3 секунды после последнего Move программа продолжится относительно \
        достигнутой точки.",
    ],
);
const TRAJECTORY_PRESSURE_FAULT: Words = words(
    [
        "The pressure does not suit ballistics; the monitor aims straight with the narrowest jet.",
        "Показания давления не подходят для баллистики; прямая наводка на самой узкой струе.",
    ],
    [
        "The pump has not yet raised the pressure, the valve is closed, or the pressure sensor is \
        faulty.",
        "Насос ещё не поднял давление, закрыт затвор либо неисправен датчик давления.",
    ],
    [
        "Wait for the pump; the flag goes as soon as the pressure is right. Else check the sensor \
        flags of General.",
        "Дождитесь насоса; флаг снимется сразу при восстановлении давления. Иначе проверьте флаги \
        датчика у General.",
    ],
);
const TRAJECTORY_RANGE_FAULT: Words = words(
    [
        "The point is too far for the jet; the monitor aims straight with the narrowest jet.",
        "Слишком далеко для баллистических возможностей ствола; прямая наводка на самой узкой \
        струе.",
    ],
    [
        "The distance is greater than the reach at this pressure, or was given wrong.",
        "Дальность больше досягаемости при этом давлении либо задана неверно.",
    ],
    [
        "Check the distance, NozzleDiameter and Height; raise the pressure or use a nearer \
        monitor.",
        "Проверьте дальность, NozzleDiameter и Height; поднимите давление или используйте более \
        близкий ствол.",
    ],
);
const TRAJECTORY_ANGLE_FAULT: Words = words(
    [
        "The elevation that ballistics ask for is too high; the monitor aims straight with the \
        narrowest jet.",
        "Слишком большой угол подъёма для баллистики; прямая наводка на самой узкой струе.",
    ],
    [
        "The point lies near the greatest reach, or MaxLimit of Vertical is low.",
        "Точка близка к предельной дальности либо занижен MaxLimit привода Vertical.",
    ],
    [
        "Raise the pressure, or the limit if the place allows it; under a roof choose another \
        monitor.",
        "Поднимите давление или предел, если позволяет место; под перекрытием выберите другой \
        ствол.",
    ],
);
const TRAJECTORY_CRC_FAULT: Words = words(
    [
        "The structure with the ballistic data is damaged.",
        "Структура с данными баллистики повреждена.",
    ],
    [
        "The stored correction table does not match its checksum: power failed while it was \
        written, or the flash is worn.",
        "Записанная таблица коррекции не совпадает с контрольной суммой: сбой питания при записи \
        либо износ ЭНОЗУ.",
    ],
    [
        "Send SetupCorrectionTable again; if the flag returns, replace the control board.",
        "Отправьте SetupCorrectionTable заново; если флаг вернётся, замените плату управления.",
    ],
);
const TRAJECTORY: Words = words(
    ["Extinguishing along trajectories is active.", "Активно тушение по траекториям."],
    ["StartTrajectory was accepted.", "Принят запрос StartTrajectory."],
    ["Nothing; Stop Control ends it.", "Ничего; завершить можно Stop Control."],
);
