use trunnion::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let bytes = std::fs::read(&a[1]).unwrap();
    let model = mesh::read_model(&bytes, &a[1], &mesh::ReadOptions { unit: None, repair: false }).unwrap();
    for p in &model.parts {
        println!("part {} {} facets {} vol {:.1}", p.id, p.name, p.mesh.facets().len(), p.mesh.volume());
    }
    for i in &model.interfaces {
        println!("{}-{} {:.3} {:?}", i.a, i.b, i.area_mm2, i.normal.as_slice());
    }
    println!("on table {:?} {:?}", model.on_table, model.warnings);
    let (file, text) = profile::shipped(&a[2]).unwrap();
    let (profile, _) = profile::resolve(file, text).unwrap();
    let placement = planning::Workpiece::centred(&model);
    let w = planning::Workpiece::place(&model, &placement);
    if let Err(e) = w.check(&profile) {
        println!("{e}");
        return;
    }
    let t = std::time::Instant::now();
    let o = planning::Options {
        objective: Box::new(orient::Staircase { layer_mm: 0.2 }),
        overhang: geom::Angle::from_deg(45.0),
        margin_mm: 0.5,
        priority: planning::Priority::Together,
        table_first: true,
        search: orient::Multistart::default(),
        budget: 1_000_000,
    };
    match planning::plan(&w, &profile, &o) {
        Ok(p) => {
            for s in &p.slots {
                println!("slot {}", s.id);
                for q in &s.prints {
                    println!("   {} {:?} {} {}", q.part, q.up, q.tilt_deg, q.rotation_deg);
                }
            }
            println!(
                "value {} lb {} clearance {} tried {} cand {} steps {}",
                p.value, p.lower_bound, p.clearance_mm, p.tried, p.candidates, p.steps
            );
        }
        Err(planning::Infeasible::NoPlan { summary, reasons }) => {
            println!("{summary}");
            for r in reasons.iter().take(40) {
                println!("  {r:?}");
            }
        }
        Err(e) => println!("{e}"),
    }
    println!("{:?}", t.elapsed());
}
