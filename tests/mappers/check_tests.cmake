# Tests of the surface checks, for tests/mappers/CMakeLists.txt.
lode_test(mappers_check_test
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/box_pairs_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/facet_grid_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/self_intersections_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/surface_edits_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/surface_match_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/surface_topology_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/surface_turning_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/triangle_intersection_test.cpp
  DEPENDS lode_mappers lode_core)

# The oracle tries every triangle for many points.
lode_test(simplify_test
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/collapse_undo_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shadow_cover_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/triangle_cuts_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/simplify_sides_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/simplify_surface_test.cpp
  DEPENDS lode_mappers lode_core
  COMPUTES TRIES)

lode_test(mesh_mappers_test
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/cell_overlap_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/cell_part_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/creases_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/mesh_boundary_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/surface_cells_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/mesh_isosurface_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/mesh_normals_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/mesh_section_test.cpp
  DEPENDS lode_mappers lode_core lode_oracles
  COMPUTES)

lode_test(tin_mappers_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/tin_bands_test.cpp ${CMAKE_CURRENT_LIST_DIR}/tin_contours_test.cpp
  DEPENDS lode_mappers lode_delaunay_selector lode_core lode_oracles
  COMPUTES)
