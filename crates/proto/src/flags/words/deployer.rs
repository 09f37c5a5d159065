//! §3.3.8 «Флаги состояния Deployer»: bits 28–31.

use super::{Words, words};

pub const DEPLOYED: Words = words(
    ["The monitor is in the working position.", "Ствол в рабочем положении."],
    [
        "It has been deployed, by Deploy, StartSeek or StartQuench.",
        "Развёрнут по Deploy, StartSeek \
    или StartQuench.",
    ],
    [
        "Nothing; it may be aimed and the valves may be opened.",
        "Ничего; можно наводить и открывать \
    затворы.",
    ],
);
pub const DEPLOYING: Words = words(
    [
        "The monitor is being deployed to the working position.",
        "Ствол разворачивается в рабочее \
    положение.",
    ],
    [
        "Deploy, StartSeek or StartQuench in the standby position.",
        "Deploy, StartSeek или \
    StartQuench в дежурном положении.",
    ],
    [
        "Keep clear of the barrel; Move and Open are denied until it ends; Stop Deployer breaks it \
        off.",
        "Не приближайтесь к стволу; до завершения Move и Open отклоняются; прервать можно Stop \
        Deployer.",
    ],
);
pub const WRAPPED: Words = words(
    ["The monitor is in the standby position.", "Ствол в дежурном положении."],
    [
        "It has been stowed, or was never deployed since power-up.",
        "Свёрнут либо не разворачивался \
    с момента включения.",
    ],
    [
        "Nothing; send Deploy before Move or Open. StartSeek and StartQuench deploy by themselves.",
        "Ничего; перед Move или Open отправьте Deploy. StartSeek и StartQuench разворачивают сами.",
    ],
);
pub const WRAPPING: Words = words(
    [
        "The monitor is being stowed to the standby position.",
        "Ствол сворачивается в дежурное \
    положение.",
    ],
    ["Wrap was accepted.", "Принят запрос Wrap."],
    [
        "Keep clear of the barrel; Move and Open are denied until it ends; Stop Deployer breaks it \
        off.",
        "Не приближайтесь к стволу; до завершения Move и Open отклоняются; прервать можно Stop \
        Deployer.",
    ],
);
