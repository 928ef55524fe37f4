#include "lode/render/camera_file.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "lode/core/atomic_file.h"
#include "lode/core/out_of_memory.h"

namespace lode {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxBytes = 64 * 1024;
constexpr std::size_t kMaxPathBytes = 16 * 1024 * 1024;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

Result<std::string> read_text(const std::string& path, std::size_t max_bytes) {
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) return fail("{}: cannot open: {}", path, std::strerror(errno));
  std::string text;
  std::array<char, 4096> piece{};
  for (std::size_t n = 1; n > 0 && text.size() <= max_bytes;) {
    n = std::fread(piece.data(), 1, piece.size(), file.get());
    text.append(piece.data(), n);
  }
  if (std::ferror(file.get()) != 0) return fail("{}: cannot read: {}", path, std::strerror(errno));
  if (text.size() > max_bytes) {
    return fail("{}: expected a camera file of at most {} bytes, got a larger one", path,
                max_bytes);
  }
  return text;
}

Result<Json> parse(const std::string& text, const std::string& path) {
  try {
    return Result<Json>(Json::parse(text));
  } catch (const nlohmann::json::exception& exception) {
    return fail("{}: expected a camera as JSON, got something else ({})", path, exception.what());
  }
}

Result<Vec3d> vector_of(const Json& value, const std::string& key, const std::string& path) {
  const Error error = fail("{}: \"{}\": expected three numbers [x, y, z]", path, key);
  if (!value.is_array() || value.size() != 3) return error;
  Vec3d v;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!value[i].is_number()) return error;
    v[i] = value[i].get<double>();
  }
  return v;
}

Json json_of(const Vec3d& v) { return Json{v[0], v[1], v[2]}; }

Result<void> set_field(Camera& camera, const std::string& key, const Json& value,
                       const std::string& path) {
  if (key == "field_of_view_deg") {
    if (!value.is_number()) return fail("{}: \"{}\": expected a number", path, key);
    camera.field_of_view_deg = value.get<double>();
    return {};
  }
  Vec3d* const target = key == "eye"      ? &camera.eye
                        : key == "target" ? &camera.target
                        : key == "up"     ? &camera.up
                                          : nullptr;
  if (target == nullptr) {
    return fail("{}: unknown field \"{}\": expected eye, target, up and field_of_view_deg", path,
                key);
  }
  LODE_TRY(*target, vector_of(value, key, path));
  return {};
}

/// `where`: the file, and of a path the frame.
Result<Camera> camera_of(const Json& json, const std::string& where) {
  if (!json.is_object())
    return fail("{}: expected one JSON object with eye and target, got {}", where,
                json.type_name());
  for (const char* required : {"eye", "target"}) {
    if (!json.contains(required)) {
      return fail("{}: expected a camera with the field \"{}\", which is missing", where, required);
    }
  }
  Camera camera;
  for (const auto& [key, value] : json.items()) LODE_CHECK(set_field(camera, key, value, where));
  if (const auto status = check_camera(camera); !status) {
    return fail("{}: {}", where, status.error().message);
  }
  return camera;
}

Json json_of(const Camera& camera) {
  return Json{{"eye", json_of(camera.eye)},
              {"target", json_of(camera.target)},
              {"up", json_of(camera.up)},
              {"field_of_view_deg", camera.field_of_view_deg}};
}

Result<void> write_json(const Json& json, const std::string& path) {
  LODE_TRY(AtomicFile file, AtomicFile::create(path));
  LODE_CHECK(file.write(json.dump(2) + "\n"));
  return file.commit();
}

}  // namespace

Result<Camera> read_camera(const std::string& path) try {
  LODE_TRY(const std::string text, read_text(path, kMaxBytes));
  LODE_TRY(const Json json, parse(text, path));
  return camera_of(json, path);
} catch (const std::bad_alloc&) {
  return out_of_memory("read the camera", path);
}

Result<void> write_camera(const Camera& camera, const std::string& path) try {
  LODE_CHECK(check_camera(camera));
  return write_json(json_of(camera), path);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the camera", path);
}

Result<std::vector<Camera>> read_cameras(const std::string& path) try {
  LODE_TRY(const std::string text, read_text(path, kMaxPathBytes));
  LODE_TRY(const Json json, parse(text, path));
  if (!json.is_array() || json.empty())
    return fail("{}: expected a JSON array of cameras, got {}", path,
                json.is_array() ? "an empty one" : json.type_name());
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < json.size(); ++i) {
    LODE_TRY(const Camera camera, camera_of(json[i], fmt::format("{}: frame {}", path, i)));
    cameras.push_back(camera);
  }
  return cameras;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the cameras", path);
}

Result<void> write_cameras(const std::vector<Camera>& cameras, const std::string& path) try {
  Json json = Json::array();
  for (const Camera& camera : cameras) {
    LODE_CHECK(check_camera(camera));
    json.push_back(json_of(camera));
  }
  return write_json(json, path);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the cameras", path);
}

}  // namespace lode
