# Tests of the checks against the full-resolution field, for tests/models/CMakeLists.txt.
lode_test(diamond_check_test
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/boundary_check_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/level_set_check_test.cpp
  DEPENDS lode_diamond lode_mappers lode_core
  COMPUTES)
