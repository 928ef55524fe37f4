# The geometric checks against the full-resolution field, for CMakeLists.txt beside this file.
set(DIAMOND_CHECK_SOURCES
  attribute_check.cpp
  boundary_check.cpp
  cell_field.cpp
  cell_neighbours.cpp
  level_set_check.cpp
  persistent_regions.cpp
  side_check.cpp
  surface_coordinates.cpp)
