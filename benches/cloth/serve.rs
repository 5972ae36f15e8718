//! Energy and gradient over a pipe, for minimisers in other languages (`benches/peers/cloth_compare.py`).
//!
//! A request is one byte and the positions: `e` is answered with the energy and its gradient, `n` with the relative energy norm; all
//! numbers are doubles of this machine. The first answer, without a request, is the number of positions and where they start.

use std::io::{ErrorKind, Read, Write};

use glam::DVec3;
use ripstop::cpu::cloth::InitialHessian;

use crate::ours;
use crate::sheet::Problem;

pub fn serve(problem: &Problem) {
    let mut cloth = ours::start(problem);
    let input = problem.input();
    let mut evaluator = cloth.evaluator(&input, InitialHessian::Multigrid);
    let mut point = evaluator.prediction_m().to_vec();
    let mut gradient = vec![DVec3::ZERO; point.len()];
    let (mut source, mut sink) = (std::io::stdin().lock(), std::io::stdout().lock());
    sink.write_all(&(3.0 * point.len() as f64).to_ne_bytes())
        .unwrap();
    sink.write_all(bytemuck::cast_slice(&point)).unwrap();
    sink.flush().unwrap();
    let mut request = [0];
    loop {
        match source.read_exact(&mut request) {
            Err(end) if end.kind() == ErrorKind::UnexpectedEof => return,
            read => read.unwrap(),
        }
        source
            .read_exact(bytemuck::cast_slice_mut(&mut point))
            .unwrap();
        let energy = evaluator.evaluate(&point, &mut gradient);
        if request == *b"e" {
            sink.write_all(&energy.to_ne_bytes()).unwrap();
            sink.write_all(bytemuck::cast_slice(&gradient)).unwrap();
        } else {
            let norm = evaluator.relative_energy_norm(&point, &gradient);
            sink.write_all(&norm.to_ne_bytes()).unwrap();
        }
        sink.flush().unwrap();
    }
}
