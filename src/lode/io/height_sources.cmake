# Reading heights; included by CMakeLists.txt beside it.
set(IO_HEIGHT_SOURCES
  crs_metric.cpp
  gdal_crs.cpp
  gdal_library.cpp
  gdal_raster.cpp
  height_hgt.cpp
  height_reader.cpp
  las_crs.cpp
  point_las.cpp
  point_reader.cpp
  point_text.cpp
  raster_file.cpp
  vector_file.cpp)

# GDAL is loaded by its name when it is needed: linked, it would triple the time to start.
find_package(GDAL REQUIRED)
get_target_property(LODE_GDAL_HEADERS GDAL::GDAL INTERFACE_INCLUDE_DIRECTORIES)
file(REAL_PATH ${GDAL_LIBRARY} LODE_GDAL_FILE)
get_filename_component(LODE_GDAL_NAME ${LODE_GDAL_FILE} NAME)
string(REGEX MATCH "^libgdal\\.so\\.[0-9]+" LODE_GDAL_NAME ${LODE_GDAL_NAME})
