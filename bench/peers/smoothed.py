"""A smooth surface in place of a mesh of flat faces: its limit under Loop subdivision, nearly.

    smoothed.py MESH TIMES OUTPUT.ply

Divides each face of MESH in four TIMES times (Open3D, Loop 1987). Files without vertex normals.
"""

import sys

import open3d

mesh = open3d.io.read_triangle_mesh(sys.argv[1])
mesh.remove_duplicated_vertices()
mesh = mesh.subdivide_loop(int(sys.argv[2]))
if not open3d.io.write_triangle_mesh(sys.argv[3], mesh, write_vertex_normals=False):
    sys.exit(f"cannot write {sys.argv[3]}")
