# Writing and reading surfaces; included by CMakeLists.txt beside it.
set(IO_SURFACE_SOURCES
  mesh_vtu.cpp
  vector_arrays.cpp
  network_vtp.cpp
  patched_spool.cpp
  surface_file.cpp
  surface_glb.cpp
  surface_input.cpp
  surface_obj.cpp
  surface_output.cpp
  surface_ply.cpp
  surface_ply_reader.cpp
  surface_stl.cpp
  surface_vtp.cpp
  surface_vtp_reader.cpp
  vtk_xml_output.cpp
  waiting_stream.cpp)
find_package(nlohmann_json REQUIRED)
