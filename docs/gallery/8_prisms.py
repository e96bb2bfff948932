"""Two layers of prisms, bent

Two layers of two closed cells under pressure, in three dimensions and on a coarse mesh: their ends are rotated against
each other. The layers gape where they are stretched (walls that are open are red), and press on each other where they
are squeezed. Prisms are run without an estimate of the error here: finer meshes take minutes.
"""

import pyvista

import ngcell

settings = ["tissue.cols=2", "mesh.order=2", "accuracy=inf", "load.levels=1"]
run = ngcell.record(ngcell.read_case("bend-layers-3d", settings), "out")
*_, step = run
print(f"energy {step.energy:.5f}, largest gap {step.largest_gap:.4f}")
print("certified:", run.certified)

cells, walls = pyvista.get_reader("out/tissue.pvd").read()
plotter = pyvista.Plotter(off_screen=True, window_size=(900, 700))
plotter.add_mesh(cells.warp_by_vector("displacement"), color="lightgrey", show_edges=False)
plotter.add_mesh(walls.warp_by_vector("displacement").threshold(0.005, scalars="gap"), color="red")
plotter.camera_position = "xz"
plotter.camera.azimuth, plotter.camera.elevation = 30, 15
plotter.screenshot("prisms.png")
print("picture: prisms.png")
