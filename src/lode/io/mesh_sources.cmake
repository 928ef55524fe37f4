# Reading unstructured meshes and making tetrahedra of them; included by CMakeLists.txt beside it.
set(IO_MESH_SOURCES
  cell_types.cpp
  grid_pieces.cpp
  mesh_checks.cpp
  mesh_ghosts.cpp
  mesh_gmsh.cpp
  mesh_gmsh_elements.cpp
  mesh_gmsh_input.cpp
  mesh_medit.cpp
  mesh_numbers.cpp
  mesh_pieces.cpp
  mesh_reader.cpp
  mesh_text.cpp
  mesh_vtk_legacy.cpp
  mesh_vtk_xml.cpp
  mesh_vtk_xml_arrays.cpp
  polyhedron_faces.cpp
  split_cells.cpp
  tetra_faces.cpp
  tetra_fields.cpp
  tetra_orientation.cpp
  tetra_winding.cpp
  tetrahedra.cpp
  weld_points.cpp)

