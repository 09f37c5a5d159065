//! Texts of the findings.

use std::fmt::Write;

use lafet_proto::bus;
use lafet_proto::dictionary::Text;

use super::{Evidence, Finding};
use crate::error::Lang;
use crate::prober::Heard;
use crate::url::{Endpoint, Framing};

const TWO_CONTROLLERS: Text = Text::new(
    "Two bus controllers on one line: switch one of them off, or give this program an address of a \
     console (src=129…254).",
    "На одной линии два контроллера сети: отключите один из них или дайте этой программе адрес \
     пульта (src=129…254).",
);

/// What was observed.
pub fn seen(finding: &Finding, evidence: &Evidence, lang: Lang) -> String {
    match lang {
        Lang::En => seen_en(finding, evidence),
        Lang::Ru => seen_ru(finding, evidence),
    }
}

/// What to do.
pub fn remedy(finding: &Finding, evidence: &Evidence, lang: Lang) -> String {
    match lang {
        Lang::En => remedy_en(finding, evidence),
        Lang::Ru => remedy_ru(finding, evidence),
    }
}

fn seen_en(finding: &Finding, evidence: &Evidence) -> String {
    let Evidence { probes, answered, .. } = evidence;
    let monitor = evidence.endpoint.addresses().monitor;
    let probed = &evidence.probed;
    match finding {
        Finding::Well => format!("The monitor answers{}.", exchange(evidence, Lang::En)),
        Finding::NoLink => format!(
            "{} cannot be used: {}.",
            evidence.endpoint,
            evidence.lost.as_deref().unwrap_or_default()
        ),
        Finding::Nothing => nothing(evidence, Lang::En),
        Finding::Echo { .. } => format!(
            "{} frames came back just as they were sent.",
            probed.echoes + evidence.exchange.as_ref().map_or(0, |e| e.heard.echoes)
        ),
        Finding::NoEcho => "The URL promises an echo (echo=), and none came.".into(),
        Finding::WrongSpeed { answers_at: Some(baud) } => format!(
            "At the speed of the URL nothing can be read{}; at {baud} baud it can.",
            sample(evidence, Lang::En)
        ),
        Finding::WrongSpeed { answers_at: None } => format!(
            "Probes are answered by {} bytes that are no frame{}; without probes the line is quiet.",
            probed.bytes,
            sample(evidence, Lang::En)
        ),
        Finding::Noise => noise(evidence, Lang::En),
        Finding::Loss => format!(
            "{answered} of {probes} probes were answered{}; nothing else was heard.",
            exchange(evidence, Lang::En)
        ),
        Finding::OtherSpeakers { addresses } => speakers(addresses, evidence, Lang::En),
        Finding::OurAddressTaken => format!(
            "Frames from or to our own address {} were heard that we have not sent or asked for.",
            evidence.endpoint.addresses().source
        ),
        Finding::OddAnswers => format!(
            "The monitor answers GetStatus General, but not as the protocol says: {}.",
            odd(evidence, Lang::En)
        ),
        Finding::NoAccess { controller: false } => {
            "The URL says role=active, and no controller was heard.".into()
        }
        Finding::NoAccess { controller: true } => format!(
            "A controller was heard, but it gives no access to our address {}.",
            evidence.endpoint.addresses().source
        ),
        Finding::MonitorSilent => {
            format!("The controller gives access, but address {monitor} does not answer.")
        }
        Finding::WrongAddress { others } => format!(
            "Address {monitor} is silent ({probes} probes); these answer: {}.",
            numbers(others)
        ),
        Finding::TwoWithOneAddress => {
            format!("One probe to address {monitor} was answered twice.")
        }
        Finding::Crc32cOnly => {
            "Frames with the usual CRC-16 get no answer, one with a CRC-32C does.".into()
        }
        Finding::OtherFraming => match evidence.endpoint.framing() {
            Framing::Link => "Link frames get no answer, a bare record does.".into(),
            Framing::Records => "Bare records get no answer, a link frame does.".into(),
        },
        Finding::OtherProtocol { text } => {
            format!("The device does not use this protocol. It sent: `{text}`")
        }
    }
}

/// Text for a link without a single received byte.
fn nothing(evidence: &Evidence, lang: Lang) -> String {
    let (probes, listened_s) = (evidence.probes, evidence.quiet_for.as_secs_f32());
    let monitor = evidence.endpoint.addresses().monitor;
    match lang {
        Lang::En => format!(
            "The link is open, but not one byte has come: {listened_s} s of listening, {probes} \
             probes to address {monitor}, probes to all other addresses."
        ),
        Lang::Ru => format!(
            "Линия открыта, но не пришло ни одного байта: прослушивание {listened_s} с, проб по \
             адресу {monitor}: {probes}, пробы по всем остальным адресам."
        ),
    }
}

/// Text for noise.
fn noise(evidence: &Evidence, lang: Lang) -> String {
    let Heard { broken, stray_bytes, .. } = total(evidence);
    let quiet = &evidence.quiet;
    let unasked = match lang {
        _ if quiet.bytes == 0 || !quiet.frames.is_empty() => String::new(),
        Lang::En => format!("; {} bytes came without a request", quiet.bytes),
        Lang::Ru => format!("; байт, пришедших без запроса: {}", quiet.bytes),
    };
    let exchange = exchange(evidence, lang);
    match lang {
        Lang::En => format!(
            "{broken} broken frames and {stray_bytes} bytes that belong to no \
             frame{unasked}{exchange}."
        ),
        Lang::Ru => format!(
            "Испорченных кадров: {broken}, байт вне кадров: {stray_bytes}{unasked}{exchange}."
        ),
    }
}

/// Text for other devices on the line.
fn speakers(addresses: &[u8], evidence: &Evidence, lang: Lang) -> String {
    let who = list(addresses, lang);
    let frames = evidence.quiet.frames.len() + strangers(evidence) + elsewhere(evidence);
    let held_back = match lang {
        _ if !evidence.held_back => "",
        Lang::En => " So nothing was sent (--insist sends).",
        Lang::Ru => " Поэтому запросы не отправлялись (--insist отправит).",
    };
    match lang {
        Lang::En => format!(
            "Other devices transmit on this line: {who}. {frames} of their frames were \
             heard.{held_back}"
        ),
        Lang::Ru => {
            format!(
                "На линии передают другие устройства: {who}. Принято кадров: {frames}.{held_back}"
            )
        }
    }
}

/// What to check if the link cannot be opened.
const fn of_link(serial: bool) -> Text {
    if serial {
        return Text::new(
            "Check the name of the port, that the adapter is plugged in, that you may use it (group \
             dialout) and that no other program has it open.",
            "Проверьте имя порта, подключён ли адаптер, есть ли права на него (группа dialout) и не \
             занят ли он другой программой.",
        );
    }
    Text::new(
        "Check host and port, that the monitor or the serial server is on, the network cable and \
         the firewall; `lafet scan HOST` looks for open ports.",
        "Проверьте узел и порт, включён ли ствол или сервер последовательных портов, сетевой кабель \
         и межсетевой экран; `lafet scan УЗЕЛ` ищет открытые порты.",
    )
}

/// What to check if nothing is received.
const fn of_silence(serial: bool) -> Text {
    if serial {
        return Text::new(
            "Check the monitor's power, that A and B are not swapped, the ground wire, that the \
             adapter switches its direction (rs485=rts if it does not do so by itself).",
            "Проверьте питание ствола, не перепутаны ли A и B, общий провод, переключает ли адаптер \
             направление (rs485=rts, если сам не умеет).",
        );
    }
    Text::new(
        "Check the monitor's power and its wires behind the serial server; a UDP port is silent \
         also when no program listens there.",
        "Проверьте питание ствола и его провода за сервером последовательных портов; порт UDP \
         молчит и тогда, когда его никто не слушает.",
    )
}

/// What to check if the speed seems wrong.
const fn of_speed(serial: bool) -> Text {
    if serial {
        return Text::new(
            "Check baud= (19200, 57600 and 115200 are in use), 8N1, and that A and B are not \
             swapped.",
            "Проверьте baud= (встречаются 19200, 57600 и 115200), 8N1 и не перепутаны ли A и B.",
        );
    }
    Text::new(
        "Set the serial server's speed to that of the monitor (19200, 57600 and 115200 are in use), \
         8N1.",
        "Установите в сервере последовательных портов скорость ствола (встречаются 19200, 57600 и \
         115200), 8N1.",
    )
}

fn remedy_en(finding: &Finding, evidence: &Evidence) -> String {
    let serial = matches!(evidence.endpoint, Endpoint::Serial { .. });
    match finding {
        Finding::Well => "Nothing to do.".into(),
        Finding::NoLink => of_link(serial).en.into(),
        Finding::Nothing => of_silence(serial).en.into(),
        Finding::Echo { told: true } => "Nothing to do: the URL says so.".into(),
        Finding::Echo { told: false } if serial => "It does no harm to lafet. With echo=strip in \
            the URL it is removed; with echo=verify a difference also shows collisions. Or \
            switch the receiver of the adapter off while it sends."
            .into(),
        Finding::Echo { told: false } => "The serial server echoes what it sends: switch the echo \
            off in it (RS-485 two-wire mode)."
            .into(),
        Finding::NoEcho => {
            "Remove echo= from the URL; without an echo it finds no collisions.".into()
        }
        Finding::WrongSpeed { answers_at: Some(baud) } => {
            format!("Write baud={baud} into the URL.")
        }
        Finding::WrongSpeed { answers_at: None } => of_speed(serial).en.into(),
        Finding::Noise => "Check termination (120 Ω at both ends only), bias resistors, ground, \
            shield and the path of the cable near motors; try a lower speed. Check = 1 of \
            ExternalConn makes the monitor take CRC-32C only."
            .into(),
        Finding::Loss => {
            "Answers come late or are lost: raise --timeout, look at the radio or the \
            network in between, and whether another program uses this link."
                .into()
        }
        Finding::OtherSpeakers { addresses } => speakers_remedy_en(addresses),
        Finding::OurAddressTaken if is_controller(evidence) => TWO_CONTROLLERS.en.into(),
        Finding::OurAddressTaken => "Give this program an address of its own (src=129…254), or \
            end the other one."
            .into(),
        Finding::WrongAddress { others } => match others.as_slice() {
            [one] => format!("Write addr={one} into the URL."),
            _ => "Write the address of the monitor you mean into the URL (addr=).".into(),
        },
        Finding::OddAnswers => {
            "Look at the monitor's program and its version: `lafet conform` shows \
            which statements of the protocol it breaks. Nothing that it answers can be \
            relied on."
                .into()
        }
        Finding::NoAccess { controller: false } => "Start the controller (`lafet bus`), or remove \
            role=active from the URL if there is none on this line."
            .into(),
        Finding::NoAccess { controller: true } => {
            "Check that the controller looks for this address \
            (--addresses) and that no other device has it (src= of the URL)."
                .into()
        }
        Finding::MonitorSilent => "Check the monitor's power and cable and addr= of the URL; \
            `lafet bus who` shows which devices are on the bus."
            .into(),
        Finding::TwoWithOneAddress => "Give one of them another address: switch the other off, \
            `lafet param set general Address N`, `lafet restart`."
            .into(),
        Finding::Crc32cOnly => "lafet's monitors answer so with Check = 1. Clients that do not \
            have it need Check = 0: `lafet param set externalconn Check 0`."
            .into(),
        Finding::OtherFraming => match evidence.endpoint.framing() {
            Framing::Link => "Write framing=records into the URL.".into(),
            Framing::Records => "Remove framing=records from the URL.".into(),
        },
        Finding::OtherProtocol { .. } => "Check the port: this is some other service.".into(),
    }
}

fn speakers_remedy_en(addresses: &[u8]) -> String {
    if !addresses.contains(&bus::CONTROLLER) {
        return "Two programs that send requests disturb each other: end the other one, or put \
                a bus controller between."
            .into();
    }
    "There is a bus controller: no device may transmit without its token. Reach the monitor \
     through the controller, or switch it off while you work directly."
        .into()
}

fn seen_ru(finding: &Finding, evidence: &Evidence) -> String {
    let Evidence { probes, answered, .. } = evidence;
    let monitor = evidence.endpoint.addresses().monitor;
    let probed = &evidence.probed;
    match finding {
        Finding::Well => format!("Ствол отвечает{}.", exchange(evidence, Lang::Ru)),
        Finding::NoLink => format!(
            "{} использовать нельзя: {}.",
            evidence.endpoint,
            evidence.lost.as_deref().unwrap_or_default()
        ),
        Finding::Nothing => nothing(evidence, Lang::Ru),
        Finding::Echo { .. } => format!(
            "Кадров, вернувшихся точно такими, как отправлены: {}.",
            probed.echoes + evidence.exchange.as_ref().map_or(0, |e| e.heard.echoes)
        ),
        Finding::NoEcho => "URL обещает эхо (echo=), но его нет.".into(),
        Finding::WrongSpeed { answers_at: Some(baud) } => format!(
            "На скорости из URL кадры не читаются{}; на {baud} бод — читаются.",
            sample(evidence, Lang::Ru)
        ),
        Finding::WrongSpeed { answers_at: None } => format!(
            "В ответ на пробы приходят байты ({}), но не кадры{}; без проб линия молчит.",
            probed.bytes,
            sample(evidence, Lang::Ru)
        ),
        Finding::Noise => noise(evidence, Lang::Ru),
        Finding::Loss => format!(
            "Ответов на пробы: {answered} из {probes}{}; больше ничего не слышно.",
            exchange(evidence, Lang::Ru)
        ),
        Finding::OtherSpeakers { addresses } => speakers(addresses, evidence, Lang::Ru),
        Finding::OddAnswers => format!(
            "Ствол отвечает на GetStatus General, но не по протоколу: {}.",
            odd(evidence, Lang::Ru)
        ),
        Finding::NoAccess { controller: false } => {
            "В URL указано role=active, но контроллера не слышно.".into()
        }
        Finding::NoAccess { controller: true } => format!(
            "Контроллер слышен, но доступа нашему адресу {} не даёт.",
            evidence.endpoint.addresses().source
        ),
        Finding::MonitorSilent => {
            format!("Контроллер даёт доступ, но адрес {monitor} не отвечает.")
        }
        Finding::OurAddressTaken => format!(
            "Слышны кадры с нашего адреса {0} или на него, которых мы не посылали и не ждали.",
            evidence.endpoint.addresses().source
        ),
        Finding::WrongAddress { others } => {
            format!("Адрес {monitor} молчит, проб: {probes}; отвечают: {}.", numbers(others))
        }
        Finding::TwoWithOneAddress => {
            format!("На одну пробу по адресу {monitor} пришло два ответа.")
        }
        Finding::Crc32cOnly => {
            "На кадры с обычной CRC-16 ответа нет, на кадр с CRC-32C — есть.".into()
        }
        Finding::OtherFraming => match evidence.endpoint.framing() {
            Framing::Link => "На канальные кадры ответа нет, на голую запись — есть.".into(),
            Framing::Records => "На голые записи ответа нет, на канальный кадр — есть.".into(),
        },
        Finding::OtherProtocol { text } => {
            format!("Устройство работает по другому протоколу. Получено: `{text}`")
        }
    }
}

fn remedy_ru(finding: &Finding, evidence: &Evidence) -> String {
    let serial = matches!(evidence.endpoint, Endpoint::Serial { .. });
    match finding {
        Finding::Well => "Делать ничего не нужно.".into(),
        Finding::NoLink => of_link(serial).ru.into(),
        Finding::Nothing => of_silence(serial).ru.into(),
        Finding::Echo { told: true } => "Делать ничего не нужно: это сказано в URL.".into(),
        Finding::Echo { told: false } if serial => {
            "Работе lafet оно не мешает. С echo=strip в URL \
            эхо отбрасывается, с echo=verify по отличиям видны ещё и столкновения. Либо отключите \
            приёмник адаптера на время передачи."
                .into()
        }
        Finding::Echo { told: false } => "Сервер последовательных портов возвращает переданное: \
            отключите в нём эхо (двухпроводный режим RS-485)."
            .into(),
        Finding::NoEcho => "Уберите echo= из URL: без эха столкновения так не найти.".into(),
        Finding::WrongSpeed { answers_at: Some(baud) } => {
            format!("Впишите в URL baud={baud}.")
        }
        Finding::WrongSpeed { answers_at: None } => of_speed(serial).ru.into(),
        Finding::Noise => "Проверьте согласующие резисторы (120 Ом только на двух концах), \
            смещение, общий провод, экран и не идёт ли кабель рядом с двигателями; попробуйте \
            меньшую скорость. Check = 1 у ExternalConn оставляет только кадры с CRC-32C."
            .into(),
        Finding::Loss => "Ответы опаздывают или теряются: увеличьте --timeout, проверьте радио \
            или сеть на пути и не пользуется ли линией кто-то ещё."
            .into(),
        Finding::OtherSpeakers { addresses } => speakers_remedy_ru(addresses),
        Finding::OurAddressTaken if is_controller(evidence) => TWO_CONTROLLERS.ru.into(),
        Finding::OurAddressTaken => "Дайте этой программе свой адрес (src=129…254) или завершите \
            другую."
            .into(),
        Finding::WrongAddress { others } => match others.as_slice() {
            [one] => format!("Впишите в URL addr={one}."),
            _ => "Впишите в URL адрес нужного ствола (addr=).".into(),
        },
        Finding::OddAnswers => {
            "Проверьте программу ствола и её версию: `lafet conform` покажет, каких \
            положений протокола она не соблюдает. Полагаться на её ответы нельзя."
                .into()
        }
        Finding::NoAccess { controller: false } => {
            "Запустите контроллер (`lafet bus`) или уберите \
            role=active из URL, если на этой линии его нет."
                .into()
        }
        Finding::NoAccess { controller: true } => "Проверьте, что контроллер ищет этот адрес \
            (--addresses) и что его нет ни у кого другого (src= в URL)."
            .into(),
        Finding::MonitorSilent => {
            "Проверьте питание и кабель ствола и addr= в URL; `lafet bus who` \
            покажет, какие устройства есть на магистрали."
                .into()
        }
        Finding::TwoWithOneAddress => "Дайте одному из них другой адрес: отключите второй, затем \
            `lafet param set general Address N`, `lafet restart`."
            .into(),
        Finding::Crc32cOnly => {
            "Так отвечают стволы lafet при Check = 1. Клиентам без CRC-32C нужен \
            Check = 0: `lafet param set externalconn Check 0`."
                .into()
        }
        Finding::OtherFraming => match evidence.endpoint.framing() {
            Framing::Link => "Впишите в URL framing=records.".into(),
            Framing::Records => "Уберите из URL framing=records.".into(),
        },
        Finding::OtherProtocol { .. } => "Проверьте порт: это какая-то другая служба.".into(),
    }
}

fn speakers_remedy_ru(addresses: &[u8]) -> String {
    if !addresses.contains(&bus::CONTROLLER) {
        return "Двое, спрашивающие без очереди, мешают друг другу: завершите другую программу или \
                поставьте контроллер сети."
            .into();
    }
    "На линии есть контроллер сети: без его разрешения говорить нельзя. Работайте со стволом через \
     контроллер либо отключите его на время прямой работы."
        .into()
}

fn is_controller(evidence: &Evidence) -> bool {
    evidence.endpoint.addresses().source == bus::CONTROLLER
}

/// Text for the result of the requests.
fn exchange(evidence: &Evidence, lang: Lang) -> String {
    let Some(exchange) = &evidence.exchange else { return String::new() };
    let (answered, sent) = (exchange.answered, exchange.sent);
    let ms = |time: std::time::Duration| format!("{:.1}", time.as_secs_f64() * 1000.0);
    let (mean, max) = (ms(exchange.rtt_mean), ms(exchange.rtt_max));
    match lang {
        Lang::En => format!(
            "; {answered} of {sent} requests were answered, in {mean} ms on average, {max} ms at \
             most"
        ),
        Lang::Ru => format!(
            "; отвечено запросов: {answered} из {sent}, в среднем за {mean} мс, не дольше {max} мс"
        ),
    }
}

/// Text for answers that break the protocol.
fn odd(evidence: &Evidence, lang: Lang) -> String {
    let Some(exchange) = &evidence.exchange else { return String::new() };
    let (odd, answered) = (exchange.odd, exchange.answered);
    let records = match (&exchange.odd_sample, lang) {
        (Some(bytes), Lang::En) if bytes.is_empty() => "; the first without records".into(),
        (Some(bytes), Lang::Ru) if bytes.is_empty() => "; первый — без записей".into(),
        (Some(bytes), _) => {
            let bytes: Vec<String> = bytes.iter().take(16).map(|b| format!("{b:02x}")).collect();
            format!(" ({})", bytes.join(" "))
        }
        (None, _) => String::new(),
    };
    match lang {
        Lang::En => format!("{odd} of {answered} answers{records}"),
        Lang::Ru => format!("ответов {odd} из {answered}{records}"),
    }
}

/// Text with the first bytes that could not be read.
fn sample(evidence: &Evidence, lang: Lang) -> String {
    let heard = if evidence.probed.bytes > 0 { &evidence.probed } else { &evidence.quiet };
    if heard.sample.is_empty() {
        return String::new();
    }
    let bytes: Vec<String> = heard.sample.iter().take(16).map(|b| format!("{b:02x}")).collect();
    let bytes = bytes.join(" ");
    match lang {
        Lang::En => format!(" (the first bytes: {bytes})"),
        Lang::Ru => format!(" (первые байты: {bytes})"),
    }
}

fn total(evidence: &Evidence) -> Heard {
    let mut total = evidence.quiet.clone();
    total.add(evidence.probed.clone());
    if let Some(exchange) = &evidence.exchange {
        total.add(exchange.heard.clone());
    }
    total
}

/// Number of frames of other devices at another speed.
fn elsewhere(evidence: &Evidence) -> usize {
    let others = evidence.speeds.iter().filter(|speed| speed.has_others());
    others.map(|speed| speed.heard.frames.len()).sum()
}

/// Number of frames of other devices received during the examination.
fn strangers(evidence: &Evidence) -> usize {
    let own = evidence.endpoint.addresses().source;
    let exchange = evidence.exchange.iter().map(|exchange| &exchange.heard);
    let heard = [&evidence.probed].into_iter().chain(exchange);
    heard.flat_map(|heard| &heard.frames).filter(|f| f.src != own && f.dst != own).count()
}

fn numbers(addresses: &[u8]) -> String {
    let all: Vec<String> = addresses.iter().map(u8::to_string).collect();
    all.join(", ")
}

fn list(addresses: &[u8], lang: Lang) -> String {
    let mut text = String::new();
    for (index, address) in addresses.iter().enumerate() {
        let kind = match (*address, lang) {
            (bus::CONTROLLER, Lang::En) => "the bus controller, ",
            (bus::CONTROLLER, Lang::Ru) => "контроллер сети, ",
            (address, Lang::En) if bus::CONSOLES.contains(&address) => "a console, ",
            (address, Lang::Ru) if bus::CONSOLES.contains(&address) => "пульт, ",
            _ => "",
        };
        let comma = if index > 0 { "; " } else { "" };
        let word = if lang == Lang::En { "address" } else { "адрес" };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{kind}{word} {address}");
    }
    text
}
