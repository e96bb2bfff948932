"""Tags and attributes of FEBio 4 (specification 4.0) that a deck may hold, and in which tag each may stand.

From the readers of FEBio 4 (FEBioXML) and the parameters of its classes: those of a planar, static, solid analysis.
"""

from __future__ import annotations

#: Attributes, by the path of tags from the root; a tag that is not here is not allowed.
ALLOWED: dict[str, set[str]] = {
    "febio_spec": {"version"},
    "febio_spec/Module": {"type"},
    "febio_spec/Material": set(),
    "febio_spec/Material/material": {"id", "name", "type"},
    "febio_spec/Material/material/solid": {"type"},
    "febio_spec/Material/material/solid/fiber": {"type"},
    "febio_spec/Mesh": set(),
    "febio_spec/Mesh/Nodes": {"name"},
    "febio_spec/Mesh/Nodes/node": {"id"},
    "febio_spec/Mesh/Elements": {"type", "name"},
    "febio_spec/Mesh/Elements/elem": {"id"},
    "febio_spec/Mesh/NodeSet": {"name"},
    "febio_spec/Mesh/Surface": {"name"},
    "febio_spec/Mesh/Surface/quad8": {"id"},
    "febio_spec/Mesh/SurfacePair": {"name"},
    "febio_spec/Mesh/SurfacePair/primary": set(),
    "febio_spec/Mesh/SurfacePair/secondary": set(),
    "febio_spec/MeshDomains": set(),
    "febio_spec/MeshDomains/SolidDomain": {"name", "mat", "type", "elem_type"},
    "febio_spec/MeshData": set(),
    "febio_spec/MeshData/ElementData": {"type", "elem_set", "name", "data_type", "format"},
    "febio_spec/MeshData/ElementData/e": {"lid"},
    "febio_spec/Boundary": set(),
    "febio_spec/Boundary/bc": {"name", "node_set", "type"},
    "febio_spec/Loads": set(),
    "febio_spec/Loads/surface_load": {"name", "surface", "type"},
    "febio_spec/Constraints": set(),
    "febio_spec/Constraints/constraint": {"name", "surface", "type"},
    "febio_spec/Step": set(),
    "febio_spec/Step/step": {"id", "name"},
    "febio_spec/Step/step/Control": set(),
    "febio_spec/Step/step/Control/time_stepper": {"type"},
    "febio_spec/Step/step/Control/solver": {"type"},
    "febio_spec/Step/step/Control/solver/qn_method": {"type"},
    "febio_spec/Step/step/Contact": set(),
    "febio_spec/Step/step/Contact/contact": {"name", "surface_pair", "type"},
    "febio_spec/LoadData": set(),
    "febio_spec/LoadData/load_controller": {"id", "type", "name"},
    "febio_spec/LoadData/load_controller/points": set(),
    "febio_spec/LoadData/load_controller/points/pt": set(),
    "febio_spec/Output": set(),
    "febio_spec/Output/plotfile": {"type", "file"},
    "febio_spec/Output/plotfile/var": {"type"},
    "febio_spec/Output/logfile": {"file"},
    "febio_spec/Output/logfile/node_data": {"data", "node_set", "file", "delim", "name", "format"},
}

#: Parameters of what has a type or stands in a section of its own; each may have a load curve, `lc`, as FEBio allows.
PARAMETERS: dict[str, set[str]] = {
    "material Mooney-Rivlin": {"density", "k", "pressure_model", "c1", "c2"},
    "solid Mooney-Rivlin": {"density", "k", "pressure_model", "c1", "c2"},
    "solid fiber-exp-pow": {"density", "alpha", "beta", "ksi", "mu", "lam0"},
    "material solid mixture": set(),
    "e": {"a", "d"},
    "constraint volume": {"laugon", "augtol", "penalty"},
    "bc zero displacement": {"x_dof", "y_dof", "z_dof"},
    "bc prescribed displacement": {"dof", "value", "relative"},
    "bc prescribed deformation": {"scale", "F", "relative"},
    "surface_load pressure": {"pressure", "linear", "symmetric_stiffness", "shell_bottom"},
    "contact sliding-elastic": {
        "laugon", "tolerance", "gaptol", "penalty", "auto_penalty", "update_penalty", "two_pass", "knmult",
        "search_tol", "symmetric_stiffness", "search_radius", "seg_up", "tension", "minaug", "maxaug", "node_reloc",
        "fric_coeff", "smooth_aug", "flip_primary", "flip_secondary", "offset",
    },
    "contact tied-elastic": {
        "laugon", "tolerance", "gaptol", "penalty", "auto_penalty", "update_penalty", "two_pass", "knmult",
        "search_tol", "symmetric_stiffness", "search_radius", "minaug", "maxaug", "flip_primary", "flip_secondary",
    },
    "Control": {"analysis", "time_steps", "step_size", "plot_level", "output_level", "plot_zero_state", "plot_stride"},
    "time_stepper default": {"max_retries", "opt_iter", "dtmin", "dtmax", "aggressiveness", "cutback", "dtforce"},
    "solver solid": {
        "symmetric_stiffness", "equation_scheme", "equation_order", "optimize_bw", "lstol", "lsmin", "lsiter",
        "max_refs", "check_zero_diagonal", "zero_diagonal_tol", "reform_each_time_step", "reform_augment",
        "diverge_reform", "min_residual", "max_residual", "dtol", "etol", "rtol", "rhoi", "alpha", "beta", "gamma",
    },
    "qn_method BFGS": {"max_ups", "max_buffer_size", "cycle_buffer", "cmax"},
    "load_controller loadcurve": {"interpolate", "extend"},
}  # fmt: skip

#: Values that are words, by their tag, or by its owner and the tag.
WORDS: dict[str, set[str]] = {
    "analysis": {"STATIC", "DYNAMIC"},
    "laugon": {"PENALTY", "AUGLAG"},
    "constraint volume laugon": {"0", "1"},
    "interpolate": {"LINEAR", "STEP", "SMOOTH"},
    "extend": {"CONSTANT", "EXTRAPOLATE", "REPEAT"},
    "pressure_model": {"default", "NIKE3D", "Abaqus"},
    "plot_level": {"PLOT_NEVER", "PLOT_MAJOR_ITRS", "PLOT_MINOR_ITRS", "PLOT_MUST_POINTS", "PLOT_FINAL"},
    "output_level": {"OUTPUT_NEVER", "OUTPUT_MAJOR_ITRS", "OUTPUT_MINOR_ITRS", "OUTPUT_MUST_POINTS", "OUTPUT_FINAL"},
}

#: Parameters that FEBio lets depend on a load curve.
CURVED = {"value", "scale", "pressure"}
