#include "pathgen/mesh/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace tiltfeed::pathgen {

namespace {

struct Float3 {
  float x, y, z;
};
struct Float4 {
  float x, y, z, r;
};

Float3 to_float(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

template <class T>
T* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
  return static_cast<T*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count));
}

void attach(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace

struct RayScene::Handles {
  // One instruction set for every machine: hits decide what is cut, and must not depend on the processor.
  RTCDevice device = rtcNewDevice("isa=sse2");
  RTCScene scene = rtcNewScene(device);
  ~Handles() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

RayScene::RayScene(Point<Part> origin) : handles_(std::make_unique<Handles>()), origin_(origin) {}
RayScene::~RayScene() = default;

void RayScene::add_triangles(const Mesh& mesh, double offset) {
  const std::size_t count = mesh.facets.size();
  RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertex = new_buffer<Float3>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, count * 3);
  auto* index =
      new_buffer<std::array<std::uint32_t, 3>>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, count);
  for (std::uint32_t i = 0; i < count; ++i) index[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  std::size_t at = 0;
  for (const auto& f : mesh.facets) {
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const Vec3 shift = normalized(cross(b - a, c - a)) * offset;
    for (Point<Part> p : {a, b, c}) vertex[at++] = to_float(p + shift - origin_);
  }
  attach(handles_->scene, geometry);
}

void RayScene::add_edges(const Mesh& mesh, double radius) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& f : mesh.facets)
    for (int i = 0; i < 3; ++i) edges.push_back(std::minmax(f[i], f[(i + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
  auto* vertex = new_buffer<Float4>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, edges.size() * 2);
  auto* index = new_buffer<std::uint32_t>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    index[i] = static_cast<std::uint32_t>(2 * i);
    for (std::size_t end = 0; end < 2; ++end) {
      const Float3 p = to_float(mesh.vertices[end == 0 ? edges[i].first : edges[i].second] - origin_);
      vertex[2 * i + end] = {p.x, p.y, p.z, static_cast<float>(radius)};
    }
  }
  attach(handles_->scene, geometry);
}

void RayScene::commit() {
  rtcSetSceneFlags(handles_->scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips between two facets
  rtcCommitScene(handles_->scene);
}

bool RayScene::hits(Point<Part> from, Vec3 direction, double length) const {
  if (length <= 0.0) return false;
  const Float3 o = to_float(from - origin_), d = to_float(direction);
  RTCRay ray{};
  ray.org_x = o.x, ray.org_y = o.y, ray.org_z = o.z;
  ray.dir_x = d.x, ray.dir_y = d.y, ray.dir_z = d.z;
  ray.tfar = static_cast<float>(length);
  ray.mask = std::numeric_limits<unsigned>::max();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(handles_->scene, &context, &ray);
  return ray.tfar < 0.0f;
}

namespace {

struct Question {
  RTCScene scene;
  Vec3 p;
  double squared;
  bool found = false;
};

Vec3 from_float(Float3 v) { return {v.x, v.y, v.z}; }

/// [Ericson 2005, 5.1.5] The squared distance of p from a triangle, by the region that p lies in.
double squared_distance(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 n = cross(b - a, c - a);
  const auto inside = [&](Vec3 u, Vec3 v) { return dot(cross(n, v - u), p - u) >= 0.0; };
  if (inside(a, b) && inside(b, c) && inside(c, a)) {
    const double height = dot(n, p - a);
    return height * height / squared_length(n);
  }
  const auto edge = [&](Vec3 u, Vec3 v) {
    const double f = std::clamp(dot(p - u, v - u) / squared_length(v - u), 0.0, 1.0);
    return squared_length(p - u - (v - u) * f);
  };
  return std::min({edge(a, b), edge(b, c), edge(c, a)});
}

bool ask(RTCPointQueryFunctionArguments* args) {
  auto& question = *static_cast<Question*>(args->userPtr);
  RTCGeometry geometry = rtcGetGeometry(question.scene, args->geomID);
  const auto* vertex =
      static_cast<const Float3*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  const Float3* corner = vertex + std::size_t{3} * args->primID;
  if (squared_distance(question.p, from_float(corner[0]), from_float(corner[1]), from_float(corner[2])) >
      question.squared)
    return false;
  question.found = true;
  args->query->radius = 0.0f;  // nothing further is asked
  return true;
}

}  // namespace

bool RayScene::within(Point<Part> p, double distance) const {
  Question question{handles_->scene, p - origin_, distance * distance};
  const Float3 at = to_float(question.p);
  RTCPointQuery query{};
  query.x = at.x, query.y = at.y, query.z = at.z;
  query.radius = static_cast<float>(distance);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(handles_->scene, &query, &context, ask, &question);
  return question.found;
}

}  // namespace tiltfeed::pathgen
