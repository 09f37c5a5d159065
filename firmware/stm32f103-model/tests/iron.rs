//! Barrels behind iron: the model of it is the simulator's, and in each combination they come to rest where they are
//! sent.

use lafet_device::image::Axis;
use lafet_proto::request::Body;
use lafet_stm32f103_model::inspect::iron::{Iron, Worst, aimed};
use lafet_stm32f103_model::rig::{Rig, Wrong};

/// An encoder on the motor sees what the simulator's own sensor there sees, the play included.
#[test]
fn an_encoder_on_the_motor_does_not_see_the_play() {
    let mut rig = Rig::new(Wrong::NOTHING, Vec::new());
    let iron = Iron { lag_ms: 100, sticks_tenths: 0, play: 12, on_motor: true };
    rig.parts(|parts| parts.plant.world.drives[3].spec.stage = iron.stage(Axis::Deployer));
    rig.run(300);
    rig.order(Axis::Deployer.id(), Body::Deploy).expect("it deploys");
    let mut apart = 0.0_f64;
    for _ in 0..300 {
        rig.run(10);
        rig.parts(|parts| {
            let drive = &parts.plant.world.drives[3];
            let sensed = parts.plant.sensed()[3];
            let other = f64::from(parts.plant.world.inputs().drives[3].position);
            assert!((sensed - other).abs() <= 0.51, "{sensed}, and the simulator's {other}");
            apart = apart.max((sensed - drive.position).abs());
        });
    }
    assert!((5.9..=6.1).contains(&apart), "{apart}' between motor and barrel");
}

fn rest_where_they_are_sent(grid: &[Iron]) {
    let mut worst = Worst::default();
    aimed(Wrong::NOTHING, grid, &mut worst).expect("all rest where they are sent");
    println!("{} combinations: {worst:.2?}", grid.len());
    assert_eq!(worst.motions as usize, 9 * grid.len());
}

#[test]
fn barrels_rest_where_they_are_sent_behind_every_iron() {
    let grid = Iron::grid(false);
    assert_eq!(grid.len(), 100);
    rest_where_they_are_sent(&grid);
}

#[test]
#[ignore = "minutes: cargo xtask firmware iron"]
fn barrels_rest_where_they_are_sent_behind_iron_in_fine_steps() {
    let grid = Iron::grid(true);
    assert_eq!(grid.len(), 1_859);
    rest_where_they_are_sent(&grid);
}
