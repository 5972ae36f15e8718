"""Times one lbmpy kernel in rounds, as told on standard input.

Every line `PATTERN SETUP PRECISION SIDE SECONDS` gives one JSON line back: million lattice updates per second of a round of that many
seconds. `PATTERN decay PRECISION SIDE STEPS` gives the relative error of the decay rate of a shear wave instead. Threads: OMP_NUM_THREADS.
Kernels are generated for AVX-512 where the CPU has it, else AVX2; the populations stay in place (AA or eso-twist).
The kernel alone is timed: no periodic exchange, which our own figures include.
"""

import json
import os
import sys
import time

import numpy as np
import pystencils as ps
from lbmpy import ForceModel, LBMConfig, LBMOptimisation, LBStencil, Method, Stencil
from lbmpy.advanced_streaming import Timestep
from lbmpy.advanced_streaming.communication import LBMPeriodicityHandling
from lbmpy.enums import SubgridScaleModel
from lbmpy.creationfunctions import create_lb_method, create_lb_update_rule
from lbmpy.macroscopic_value_kernels import macroscopic_values_getter, macroscopic_values_setter
from pystencils import CreateKernelConfig, Target

TAU = 0.6
# Magic parameter 3/16, as in our own operator.
RATES = [1.0 / TAU, 1.0 / (0.5 + 3.0 / 16.0 / (TAU - 0.5))]
THREADS = int(os.environ.get("OMP_NUM_THREADS", "1"))


def instruction_set():
    with open("/proc/cpuinfo") as info:
        return "avx512" if "avx512f" in info.read() else "avx"


class Kernel:
    def __init__(self, pattern, setup, precision, side):
        dtype = np.float32 if precision == "f32" else np.float64
        self.name, self.side, self.pattern = (pattern, setup, precision, side), side, pattern
        stencil = LBStencil(Stencil.D3Q19)
        data = ps.create_data_handling((side,) * 3, periodicity=True, default_target=Target.CPU, default_ghost_layers=1)
        f = data.add_array("f", values_per_cell=19, dtype=dtype, alignment=True, layout="fzyx")
        u = data.add_array("u", values_per_cell=3, dtype=dtype, alignment=True, layout="fzyx")
        extra = {}
        self.arrays = {"f": "f"}
        if setup == "canopy":
            force = data.add_array("force", values_per_cell=3, dtype=dtype, alignment=True, layout="fzyx")
            data.fill("force", 1e-7, ghost_layers=True)
            extra = dict(
                subgrid_scale_model=(SubgridScaleModel.SMAGORINSKY, 0.15), force=force.center_vector, force_model=ForceModel.GUO, output={"velocity": u})
            self.arrays |= {"force": "force", "u": "u"}
            method, rates = Method.SRT, RATES[:1]
        else:
            method, rates = Method.TRT, RATES
        typed = dict(data_type=precision.replace("f", "float"), default_number_float=precision.replace("f", "float"))
        self.kernels = []
        for step in (Timestep.EVEN, Timestep.ODD):
            config = LBMConfig(
                stencil=stencil, method=method, relaxation_rates=rates, compressible=False, zero_centered=True,
                streaming_pattern=pattern, timestep=step, **extra)
            rule = create_lb_update_rule(
                lbm_config=config,
                lbm_optimisation=LBMOptimisation(symbolic_field=f, cse_global=True, field_layout="fzyx"))
            vectors = dict(
                instruction_set=instruction_set(), nontemporal=False, assume_aligned=True,
                assume_inner_stride_one=True, assume_sufficient_line_padding=True)
            kernel = CreateKernelConfig(
                target=Target.CPU, cpu_openmp=THREADS, ghost_layers=1, skip_independence_check=True,
                cpu_vectorize_info=vectors, **typed)
            self.kernels.append(ps.create_kernel(rule, config=kernel).compile())
        data.fill("f", 0.0, ghost_layers=True)
        self.data, self.odd = data, 0
        self.set_up = (stencil, method, rates, f, u, typed)
        self.advance(4)

    def advance(self, steps):
        arrays = {name: self.data.cpu_arrays[array] for name, array in self.arrays.items()}
        for _ in range(steps):
            self.kernels[self.odd](**arrays)
            self.odd ^= 1

    def timed(self, seconds):
        start, steps = time.perf_counter(), 0
        while (elapsed := time.perf_counter() - start) < seconds:
            self.advance(2)
            steps += 2
        return self.side**3 * steps / elapsed * 1e-6

    def decay_error(self, steps):
        """u_x = 0.02 sin(k y) decays at ν k²."""
        stencil, method, rates, f, u, typed = self.set_up
        config = LBMConfig(stencil=stencil, method=method, relaxation_rates=rates, compressible=False, zero_centered=True)
        method = create_lb_method(config)
        last = Timestep.ODD
        common = dict(streaming_pattern=self.pattern, previous_timestep=last)
        plain = CreateKernelConfig(target=Target.CPU, ghost_layers=1, **typed)
        setter = ps.create_kernel(macroscopic_values_setter(method, 1.0, u.center_vector, f, **common), config=plain).compile()
        getter = ps.create_kernel(macroscopic_values_getter(method, None, u.center_vector, f, **common), config=plain).compile()
        exchange = LBMPeriodicityHandling(stencil, self.data, "f", streaming_pattern=self.pattern)
        a = self.data.cpu_arrays
        y = (np.arange(self.side + 2) - 0.5) * 2 * np.pi / self.side
        a["u"][...] = 0.0
        a["u"][..., 0] = 0.02 * np.sin(y)[None, :, None]
        setter(f=a["f"], u=a["u"])
        exchange(last)
        self.odd = 0
        for step in range(steps):
            self.advance(1)
            exchange(Timestep.EVEN if step % 2 == 0 else Timestep.ODD)
        getter(f=a["f"], u=a["u"])
        inner = a["u"][1:-1, 1:-1, 1:-1, 0].astype(float)
        amplitude = 2 * np.mean(inner * np.sin(y[1:-1])[None, :, None])
        k = 2 * np.pi / self.side
        return np.log(0.02 / amplitude) / steps / ((TAU - 0.5) / 3 * k * k) - 1


kernel = None
for line in sys.stdin:
    pattern, setup, precision, side, amount = line.split()
    try:
        if setup == "decay":
            answer = {"decay_rate_error": Kernel(pattern, "trt", precision, int(side)).decay_error(int(amount))}
        else:
            if kernel is None or kernel.name != (pattern, setup, precision, int(side)):
                kernel = None
                kernel = Kernel(pattern, setup, precision, int(side))
            answer = {"million_lattice_updates_per_s": kernel.timed(float(amount))}
    except Exception as error:  # the driver decides what a failed kernel means
        answer = {"error": f"{type(error).__name__}: {error}"[:300]}
    print(json.dumps(answer), flush=True)
