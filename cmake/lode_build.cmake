# Compiler settings, packages and the two functions every room uses.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

set(LODE_SANITIZE "" CACHE STRING "Sanitizers, as given to -fsanitize=")

find_program(LODE_CCACHE ccache)
if(LODE_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${LODE_CCACHE})
endif()

find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(PkgConfig REQUIRED)

add_library(lode_settings INTERFACE)
# No contraction and no fast-math: each result that reaches an output has one order of operations.
target_compile_options(lode_settings INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror
                                               -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12's straight-line vectoriser drops double -> float -> double in pairs: it would take
  # coordinates for exact in float32 that are not (a test of io/surface_input fails with it).
  target_compile_options(lode_settings INTERFACE -fno-tree-slp-vectorize)
endif()
target_include_directories(lode_settings INTERFACE ${PROJECT_SOURCE_DIR}/src)
if(LODE_SANITIZE)
  # GCC 12 warns of bounds in code that only instrumenting made; the release build decides.
  # Not for targets that have the property LODE_UNSANITIZED.
  set(is_sanitized $<NOT:$<BOOL:$<TARGET_PROPERTY:LODE_UNSANITIZED>>>)
  target_compile_options(lode_settings INTERFACE
    -Wno-error $<${is_sanitized}:-fsanitize=${LODE_SANITIZE}>
    -fno-omit-frame-pointer $<${is_sanitized}:-fno-sanitize-recover=all>)
  target_link_options(lode_settings INTERFACE $<${is_sanitized}:-fsanitize=${LODE_SANITIZE}>)
endif()

if(LODE_BUILD_FUZZERS)
  target_compile_options(lode_settings INTERFACE -fsanitize=fuzzer-no-link)
endif()

# lode_room(NAME SOURCES ... [DEPENDS targets...]): one static library, lode_NAME.
function(lode_room name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(lode_${name} STATIC ${ARG_SOURCES})
  target_link_libraries(lode_${name} PUBLIC lode_settings ${ARG_DEPENDS})
  # One compilation per room: headers, which cost most of the time, are read once.
  set_target_properties(lode_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  # To such a unit the unnamed namespaces of its files look like those of headers.
  target_compile_options(lode_${name} PRIVATE -Wno-subobject-linkage)
endfunction()

# lode_test(NAME SOURCES ... [DEPENDS targets...] [LABEL fast|slow] [COMPUTES] [TRIES]): one GoogleTest
# program, compiled at once like a room and registered with CTest test by test. COMPUTES: the tests
# themselves work hard (oracles) and are optimised; the others would only compile longer. TRIES: they
# take a part of their cases (tests/oracles/trials.h), which a slow test, every_trial_of_NAME, takes
# all of.
function(lode_test name)
  cmake_parse_arguments(ARG "COMPUTES;TRIES" "LABEL" "SOURCES;DEPENDS" ${ARGN})
  set(optimise -O0)
  if(ARG_COMPUTES)
    set(optimise -O1)
  endif()
  if(NOT ARG_LABEL)
    set(ARG_LABEL fast)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE lode_settings ${ARG_DEPENDS} GTest::gtest_main)
  # Tests name only the options they set.
  target_compile_options(${name} PRIVATE -Wno-missing-field-initializers -Wno-dangling-else
                                         $<$<CONFIG:Release>:${optimise}>)
  target_compile_definitions(${name} PRIVATE
    LODE_SAMPLES_DIR="${PROJECT_SOURCE_DIR}/samples"
    LODE_TEST_FILES_DIR="${PROJECT_SOURCE_DIR}/tests/files")
  gtest_discover_tests(${name} PROPERTIES LABELS ${ARG_LABEL} DISCOVERY_TIMEOUT 60)
  if(ARG_TRIES)
    add_test(NAME every_trial_of_${name} COMMAND ${name})
    set_tests_properties(every_trial_of_${name} PROPERTIES LABELS slow TIMEOUT 3600
                                                           ENVIRONMENT LODE_TRIALS=all)
  endif()
endfunction()
