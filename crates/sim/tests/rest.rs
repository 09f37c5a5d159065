//! Passing over rest is the same as stepping through it: two monitors with the same seed, the same
//! requests, faults and buttons, one stepped plainly, the other passing over whatever rests. All
//! that can be seen of them is the same, byte for byte.

use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_proto::flags::Button;
use lafet_proto::record::Writer;
use lafet_proto::text;
use lafet_sim::fault::{Fault, Post};
use lafet_sim::rng::Rng;
use lafet_sim::sim::{Config, Sim};

const SEEDS: u64 = 24;
const ACTIONS: u32 = 25;

const REQUESTS: [&str; 24] = [
    "Deploy",
    "Deploy",
    "Wrap",
    "Move Vertical 900",
    "Move Horizontal -21600",
    "Move Nozzle 20",
    "Open Valve1",
    "Open Valve2",
    "Close Valve1",
    "Close Valve1",
    "Close Valve2",
    "Stop All",
    "StartSeek -600 600 -100 300",
    "StartQuench centre=600,-100 nozzle=60 sector=240,60 step=1 distance=25",
    "Stop Control",
    "StartJustify",
    "SwitchLimits Motors off",
    "SwitchLimits Motors on",
    "SetParam Vertical Speed 5",
    "SetParam Climatics HeatOn 150",
    "SetParam General MoveTimeout 500",
    "Lockout on",
    "Lockout off",
    "Restart",
];

fn payload(request: &str) -> Vec<u8> {
    let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
    let mut writer = Writer::new(&mut record);
    let request = text::parse(request, &mut buffer).expect("a request");
    request.encode(&mut writer).expect("room");
    writer.written().to_vec()
}

/// Does one thing to a monitor; returns what it answers.
fn act(sim: &mut Sim, rng: &mut Rng, faults: &[Fault]) -> Vec<u8> {
    match rng.bits() % 20 {
        0 => sim.power_cycle(),
        1 | 2 => {
            let fault = faults[rng.bits() as usize % faults.len()];
            sim.world_mut().inject(fault);
        }
        3 | 4 => sim.world_mut().clear_all(),
        5 | 6 => {
            let button = Button::ALL[rng.bits() as usize % 8];
            let pressed = rng.chance(0.3);
            sim.world_mut().press(Post::ALL[rng.bits() as usize % 2], button, pressed);
        }
        7 => sim.world_mut().climate.ambient_c = rng.unit() * 80.0 - 40.0,
        8 => {
            let fire = "az=10,range=25,size=1".parse().expect("a fire");
            sim.world_mut().light(fire);
        }
        9 => sim.world_mut().sweep(),
        _ => {
            let request = REQUESTS[rng.bits() as usize % REQUESTS.len()];
            return sim.request(Source::ExternalConn, &payload(request));
        }
    }
    Vec::new()
}

/// Everything that can be seen of a monitor and its world.
fn shown(sim: &mut Sim) -> String {
    let answers = sim.request(Source::Radio, &payload("GetStatus All"));
    let line = sim.trace_line();
    let world = sim.world_mut();
    let events = world.take_events();
    // The last digit of every number, and the state of all that is random.
    format!(
        "{answers:02x?}\n{line}\n{events:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}",
        world.inputs(),
        world.outputs(),
        world.drives,
        world.valves,
        world.water,
        world.climate,
        world.rng()
    )
}

#[test]
fn the_same_as_step_by_step() {
    let faults: Vec<Fault> = Fault::all().collect();
    let mut passed_over = 0;
    for seed in 0..SEEDS {
        let composition = Composition::ALL[(seed % 5) as usize];
        // Soon the clock wraps.
        let clock_ms = if seed % 2 == 0 { 0 } else { u32::MAX - 90_000 };
        let gusts = if seed % 8 == 7 { 0.3 } else { 0.0 };
        let config = Config { seed, composition, clock_ms, gusts, ..Config::default() };
        let (mut plain, mut fast) = (Sim::new(config.clone()), Sim::new(config));
        let mut rng = Rng::new(seed);
        for action in 0..ACTIONS {
            let ms = 10 * [1, 13, 400, 2_000, 12_345][rng.bits() as usize % 5];
            plain.advance_ms(ms);
            fast.pass_ms(ms);
            let what = format!("seed {seed}, action {action}, after {ms} ms");
            assert_eq!(shown(&mut plain), shown(&mut fast), "{what}");
            assert!(plain.device().is_same_state(fast.device()), "{what}: the monitor's state");
            let answer = act(&mut plain, &mut rng.clone(), &faults);
            assert_eq!(act(&mut fast, &mut rng, &faults), answer, "{what}");
            assert!(
                plain.world().flash.to_bytes() == fast.world().flash.to_bytes(),
                "{what}: the memory"
            );
        }
        passed_over += fast.passed_over_ms();
    }
    println!("{passed_over} ms passed over");
    assert!(passed_over > 1_000_000, "{passed_over} ms");
}
