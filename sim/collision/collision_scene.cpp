#include "sim/collision/collision_scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/solid/tool_solid.h"

namespace tiltfeed::sim {
namespace {

// A round body's axis is a rotary's where both are nearer than this, mm, and their sine less than its
// thousandth.
constexpr double kSameLine = 1e-6;

constexpr std::array<const char*, 9> kLinkNames{"bed",    "x slide", "y slide", "z slide", "table",
                                                "cradle", "fork",    "head",    "nose"};

Vec3 off_line(const LineJoint& line, Vec3 p) {
  const Vec3 from = p - line.point;
  return from - line.direction * dot(from, line.direction);
}

bool is_machine(BodyKind kind) {
  return kind == BodyKind::kMachineUnderWork || kind == BodyKind::kMachineOverWork;
}
bool is_tool(BodyKind kind) {
  return kind == BodyKind::kCutter || kind == BodyKind::kShank || kind == BodyKind::kHolder;
}

BodyKind kind_of(const config::MachineBodies& machine, config::BodyLink link) {
  using config::BodyLink;
  const auto under = [&](int axis) {
    return std::find(machine.work_slides.begin(), machine.work_slides.end(), axis) !=
           machine.work_slides.end();
  };
  const bool work = link == BodyLink::kBed || link == BodyLink::kTable || link == BodyLink::kCradle ||
                    (link == BodyLink::kXSlide && under(0)) || (link == BodyLink::kYSlide && under(1)) ||
                    (link == BodyLink::kZSlide && under(2));
  return work ? BodyKind::kMachineUnderWork : BodyKind::kMachineOverWork;
}

double clearance_of(const config::Clearances& c, BodyKind kind) {
  switch (kind) {
    case BodyKind::kMachineUnderWork:
      return c.table;
    case BodyKind::kMachineOverWork:
      return c.head;
    case BodyKind::kCutter:
      return c.cutter;
    case BodyKind::kShank:
      return c.shank;
    case BodyKind::kHolder:
      return c.holder;
    case BodyKind::kPart:
    case BodyKind::kFixture:
      break;
  }
  return 0.0;
}

/// Joined by a slide or bearing, fixed to each other, or the matter of the proof of gouges.
bool exempt(const BodyGroup& a, const BodyGroup& b) {
  if (a.link == b.link) return true;
  if (is_machine(a.kind) && is_machine(b.kind)) return std::abs(a.link - b.link) <= 1;
  return (is_tool(a.kind) && b.kind == BodyKind::kPart) || (is_tool(b.kind) && a.kind == BodyKind::kPart);
}

}  // namespace

const BodyGroup::Body& BodyGroup::body_of(std::uint32_t facet) const {
  return *std::find_if(bodies.begin(), bodies.end(), [&](const Body& body) { return facet < body.end; });
}

double BodyPair::motion(const AxisWords& by) const {
  const double slide = std::hypot(slides[0] ? by[0] : 0.0, slides[1] ? by[1] : 0.0, slides[2] ? by[2] : 0.0);
  const auto turn = [](double r, double degrees) {
    return r > 0.0 ? 2.0 * r * std::sin(0.5 * std::min(Angle::from_degrees(degrees).radians(), kPi)) : 0.0;
  };
  return slide + turn(reach[0], by[kTiltAxis]) + turn(reach[1], by[kRotaryAxis]);
}

BodyGroup& CollisionScene::group(BodyKind kind, int link, const std::string& word) {
  for (BodyGroup& group : groups_)
    if (group.word == word) return group;
  BodyGroup& fresh = groups_.emplace_back();
  fresh.kind = kind, fresh.link = link, fresh.word = word;
  return fresh;
}

void CollisionScene::add(BodyGroup& group, const std::string& name, const SolidMesh& mesh) {
  group.tree.add(mesh.vertices, mesh.facets);
  const std::uint32_t before = group.bodies.empty() ? 0 : group.bodies.back().end;
  group.sagitta = std::max(group.sagitta, mesh.sagitta);
  group.bodies.push_back({name, before + static_cast<std::uint32_t>(mesh.facets.size()), mesh.vertices,
                          mesh.round, mesh.centre, mesh.axis});
}

Result<void> CollisionScene::add_machine(const config::MachineProfile& machine) {
  for (const config::MachineBody& body : machine.solid.bodies) {
    auto mesh = mesh_of(body.shape);
    if (!mesh)
      return fail(mesh.error().code, machine.path + ": body " + body.name + ": " + mesh.error().message);
    mesh->place({}, line_.origin(body.link));
    add(group(kind_of(machine.solid, body.link), line_.link(body.link),
              kLinkNames[static_cast<std::size_t>(body.link)]),
        body.name, *mesh);
  }
  return {};
}

Result<void> CollisionScene::add_fixtures(const config::Job& job) {
  for (const config::Fixture& fixture : job.fixtures) {
    auto mesh = mesh_of(fixture.shape);
    if (!mesh)
      return fail(mesh.error().code, job.path + ": fixture " + fixture.name + ": " + mesh.error().message);
    if (fixture.on_part)
      mesh->place(line_.part().rotation, line_.part().shift);
    else
      mesh->place({}, line_.table());
    add(group(BodyKind::kFixture, line_.work(), "fixture"), fixture.name, *mesh);
  }
  return {};
}

void CollisionScene::add_tool(const pathgen::Cutter& cutter) {
  const ToolSolid solid(cutter, {}, 0.0);
  constexpr std::array<BodyKind, 3> kKinds{BodyKind::kCutter, BodyKind::kShank, BodyKind::kHolder};
  for (const ToolPart part : kToolParts) {
    const auto index = static_cast<std::size_t>(part);
    for (const Revolved& piece : solid.pieces(part)) {
      SolidMesh mesh = mesh_of(piece);
      mesh.place(line_.tip().rotation, line_.tip().shift);
      add(group(kKinds[index], line_.tool(), kToolPartNames[index]), "", mesh);
    }
  }
}

void CollisionScene::add_part(const pathgen::CheckedMesh& part) {
  SolidMesh mesh;
  mesh.facets = part.mesh.facets;
  for (const auto& v : part.mesh.vertices) mesh.vertices.push_back(from_origin(v));
  mesh.place(line_.part().rotation, line_.part().shift);
  add(group(BodyKind::kPart, line_.work(), "part"), "", mesh);
}

/// The greatest distance from the rotary's axis of any point of the group, in any place of what turns
/// between: a point that goes round another axis is nowhere further than the middle of its circle and the
/// circle's radius.
double CollisionScene::reach_of(const BodyGroup& group, int from, int to, const LineJoint& about) const {
  const LineJoint* between = nullptr;
  for (int k = from; k < to; ++k) {
    const LineJoint& joint = line_.joints()[static_cast<std::size_t>(k)];
    if (!joint.turns() || between != nullptr) return kInfinity;
    between = &joint;
  }
  double most = 0.0;
  for (const BodyGroup::Body& body : group.bodies) {
    const bool turns_in_itself = body.round && between == nullptr &&
                                 length(off_line(about, body.centre)) < kSameLine &&
                                 length(cross(body.axis, about.direction)) < 1e-3 * kSameLine;
    if (turns_in_itself) continue;
    for (const Vec3 v : body.vertices) {
      if (between == nullptr) {
        most = std::max(most, length(off_line(about, v)));
        continue;
      }
      const Vec3 aside = off_line(*between, v);
      most = std::max(most, length(off_line(about, v - aside)) + length(aside));
    }
  }
  return most;
}

/// (CO3) The lesser of what either side reaches.
double CollisionScene::reach(const BodyPair& pair, std::size_t joint) const {
  const int at = static_cast<int>(joint);
  const BodyGroup &a = groups_[pair.a], &b = groups_[pair.b];
  const LineJoint& about = line_.joints()[joint];
  return std::min(reach_of(a, a.link, at, about), reach_of(b, at + 1, b.link, about));
}

void CollisionScene::find_pairs(const config::Clearances& clearances, double stray) {
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    for (std::size_t k = i + 1; k < groups_.size(); ++k) {
      if (exempt(groups_[i], groups_[k])) continue;
      BodyPair pair;
      pair.a = groups_[i].link < groups_[k].link ? i : k, pair.b = pair.a == i ? k : i;
      const BodyGroup &a = groups_[pair.a], &b = groups_[pair.b];
      const double room = std::max(clearance_of(clearances, a.kind), clearance_of(clearances, b.kind));
      const double shapes = a.sagitta + b.sagitta + stray;
      pair.clearance = room + shapes, pair.rapid_clearance = clearances.rapid_factor * room + shapes;
      for (int joint = a.link; joint < b.link; ++joint) {
        const auto at = static_cast<std::size_t>(joint);
        const std::size_t axis = line_.joints()[at].axis;
        if (axis < kTiltAxis)
          pair.slides[axis] = true;
        else
          pair.reach[axis - kTiltAxis] = reach(pair, at);
      }
      pairs_.push_back(pair);
    }
  }
  assert(pairs_.size() <= kMostPairs);
}

Result<CollisionScene> CollisionScene::make(const pathgen::CheckedMesh& part, const config::Job& job) {
  CollisionScene scene(job);
  if (job.machine.solid.bodies.empty() && job.fixtures.empty()) return scene;
  if (auto added = scene.add_machine(job.machine); !added) return tl::unexpected(added.error());
  if (auto added = scene.add_fixtures(job); !added) return tl::unexpected(added.error());
  scene.add_tool(job.plan.cutter);
  if (!job.machine.solid.bodies.empty()) scene.add_part(part);
  for (BodyGroup& group : scene.groups_) group.tree.build();
  scene.find_pairs(job.machine.solid.clearances, job.machine.format.tcp ? kTcpStray : 0.0);
  return scene;
}

}  // namespace tiltfeed::sim
