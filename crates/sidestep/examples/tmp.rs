#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]
use std::sync::Arc; use std::ops::ControlFlow; use std::time::Instant;
use rayon::prelude::*;
use sidestep::{objective::*, optimizer::*, profile::*, rng::*, run::*, suite::*, starts::*};
fn main(){
  let seeds=[2u64,12,22,32,42];
  for (pname, prof) in [("paper",Profile::PAPER),("default",Profile::DEFAULT)] {
  for (name,m) in [("gd .1",Method::GradientDescent{step:Some(0.1)}),("gd .5",Method::GradientDescent{step:Some(0.5)}),("gd 1",Method::GradientDescent{step:Some(1.0)}),("gd 2",Method::GradientDescent{step:Some(2.0)}),("gd 4",Method::GradientDescent{step:Some(4.0)}),("ls 1",Method::LineSearch{step:4.0}),("mom",Method::Momentum{step:Some(0.1),decay:0.9}),("adam .1",Method::Adam{step:0.1}),("chomp .05",Method::Chomp{step:Some(0.05)}),("chomp .2",Method::Chomp{step:Some(0.2)}),("lbfgs",Method::Lbfgs{memory:7}),("stomp",Method::Stomp{rollouts:16,noise:0.5})] {
    let t=Instant::now(); let mut tot=[0f64;5]; let mut steps=0usize;
    for s in seeds { let tasks=Suite::Easy.generate(400,s,&Profile::PAPER);
      let r:Vec<Run>=tasks.par_iter().enumerate().map(|(i,t)|{ let sc=Arc::new(Scene::new(&t.world,t.robot,&prof)); let mut o=Objective::new(t,sc,10).unwrap(); let mut op=Optimizer::new(&m,t,&o,stream(0,Purpose::Planner,i as u64,0)).unwrap(); let mut x=vec![0.0;20]; StartStrategy::Line.draw(&o,t.world.bounds(),&mut stream(0,Purpose::Start,i as u64,0),&mut x); run(&mut o,&mut op,&mut x,200,Until::Spent,|_|ControlFlow::Continue(()))}).collect();
      for r in &r { steps+=r.steps; tot[0]+=r.first_feasible.is_some() as u8 as f64; tot[1]+=r.feasible_at_end as u8 as f64; tot[2]+=r.first_certified.is_some() as u8 as f64;}
    }
    println!("{pname} {name}: any {:.2} end {:.2} certified {:.2}  {:.3} us/iter(2 cores)", tot[0]/20.,tot[1]/20.,tot[2]/20., t.elapsed().as_secs_f64()*1e6/steps as f64);
  }}
}
