# Tests of writing and reading surfaces; included by CMakeLists.txt beside it.
lode_test(io_surface_test
  SOURCES
    surface_file_test.cpp
    surface_glb_test.cpp
    surface_obj_test.cpp
    surface_origins_test.cpp
    surface_ply_test.cpp
    surface_stl_test.cpp
    surface_stream_test.cpp
    surface_vtk_test.cpp
    surface_vtp_test.cpp
  DEPENDS lode_io)
target_compile_definitions(io_surface_test PRIVATE
  LODE_SURFACE_ORACLE="${CMAKE_CURRENT_LIST_DIR}/surface_oracle.py")
lode_test(io_mesh_test
  SOURCES mesh_file_test.cpp mesh_vtu_test.cpp
  DEPENDS lode_io nlohmann_json::nlohmann_json)
target_compile_definitions(io_mesh_test PRIVATE
  LODE_MESH_CONTENT="${CMAKE_CURRENT_LIST_DIR}/mesh_content.py"
  LODE_MESH_ORACLE="${CMAKE_CURRENT_LIST_DIR}/mesh_oracle.py")
