# The surface checks of `lode verify --surface`, for src/lode/mappers/CMakeLists.txt:
# MAPPERS_CHECK_SOURCES and MAPPERS_CHECK_DEPENDS.
set(MAPPERS_CHECK_SOURCES
  box_pairs.cpp
  coincident_vertices.cpp
  line_topology.cpp
  self_intersections.cpp
  surface_checks.cpp
  surface_match.cpp
  surface_topology.cpp
  surface_turning.cpp
  triangle_intersection.cpp
  vertex_corners.cpp)

# CGAL's exact predicates are headers over GMP and MPFR. Their interval filters switch the rounding
# mode, which the compiler must be told, and only in the one file that includes them.
set(MAPPERS_CHECK_DEPENDS gmp mpfr)
set_source_files_properties(triangle_intersection.cpp PROPERTIES COMPILE_OPTIONS -frounding-math)
