use std::sync::Arc;
fn main() {
    let mut args = std::env::args().skip(1);
    let file = args.next().unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let exercise = match lafet_sim::exercise::Exercise::parse(&file, &text) { Ok(e) => e, Err(p) => { eprintln!("{p}"); std::process::exit(2) } };
    let seed = exercise.site.seed;
    let t = std::time::Instant::now();
    let o = lafet_sim::exercise::run(&Arc::new(exercise), seed, false);
    eprintln!("{:?}", t.elapsed());
    println!("{}", lafet_sim::exercise::text(&o, lafet_sim::exercise::Lang::En));
    if let Some(svg) = args.next() { std::fs::write(svg, lafet_sim::exercise::svg(&o, if args.next().is_some() {lafet_sim::exercise::Lang::Ru} else {lafet_sim::exercise::Lang::En})).unwrap(); }
}
