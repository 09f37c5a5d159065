//! §3.3.9 «Флаги состояния ExternalConn, Radio»: ConnLost has a meaning of its own.

use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// State of ExternalConn or Radio (§3.3, §3.3.9), 4 bytes.
    ConnStatus [flags: ConnFlags] {}
}

flag_class! {
    /// §3.3.9 ExternalConn, Radio: no flags of their own; ConnLost means that no client controls.
    ConnFlags "3.3.9", ConnLost Notice CONN_LOST, width 1;
}

const CONN_LOST: Words = words(
    [
        "No client has controlled the monitor through this interface lately (3 s by default).",
        "По этому интерфейсу никто не управлял стволом (по умолчанию 3 секунды).",
    ],
    [
        "Ordinary while no client commands; status polls do not count. Else a broken line, wrong \
        address or speed, a silent modem.",
        "Обычно, пока команд нет; опрос состояния не считается. Иначе обрыв линии, неверный адрес \
        или скорость, молчит модем.",
    ],
    [
        "If commands are being sent and the flag stays, check line, address and baud rate, or the \
        modem's antenna and channel.",
        "Если команды подаются, а флаг стоит, проверьте линию, адрес и скорость либо антенну и \
        канал модема.",
    ],
);
