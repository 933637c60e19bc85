"""The plan of a scene, as `Material.plan` returns it.

SPDX-License-Identifier: MIT
"""
from . import _options as o


class Plan:
    """The cheapest way to decode a scene within a tolerance (openbtf/plan.h, btf_plan).

    Attributes: `effects` (names), `components`, `interpolation`, `filter`, `level`, `gpu_bytes`, `full_gpu_bytes`,
    `cost` and `full_cost` (ns a pixel of the model: ratios mean something), `psnr` and `full_psnr` (linear, sRGB-coded
    dB at the samples), `between_psnr`, `full_between_psnr` (between them; None where the file does not know), `fold`,
    `price` (what plans are compared by: relative time, folded where that is less, plus relative bytes).
    """

    def __init__(self, plan):
        self._c = plan
        self.effects = o.names_of(plan.effects)
        self.components = plan.components
        self.interpolation = "nearest" if plan.shader.interpolation else "linear"
        self.filter = list(o.FILTERS)[plan.shader.filter]
        self.level = plan.level
        self.gpu_bytes = plan.gpu_bytes
        self.full_gpu_bytes = plan.full_gpu_bytes
        self.cost = plan.cost
        self.full_cost = plan.full_cost
        self.measured = bool(plan.measured)
        self.psnr = (plan.psnr_linear, plan.psnr_srgb)
        self.full_psnr = (plan.full_psnr_linear, plan.full_psnr_srgb)
        known = plan.full_between_psnr_linear != 0
        self.between_psnr = (plan.between_psnr_linear, plan.between_psnr_srgb) if known else None
        self.full_between_psnr = (plan.full_between_psnr_linear, plan.full_between_psnr_srgb) if known else None
        self.fold = list(o.FOLDS)[plan.fold]
        self.price = plan.price

    def __repr__(self):
        return "<openbtf.Plan: %s, %d components, level %d, %s of %s bytes, %.0f %% of the time>" % (
            ", ".join(self.effects) or "no effects", self.components, self.level, format(self.gpu_bytes, ","),
            format(self.full_gpu_bytes, ","), 100 * self.cost / self.full_cost if self.full_cost else 100)
