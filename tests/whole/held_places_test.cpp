// The check of collisions against plain distances of solids, at 1,000 places of each block that is asked: of
// programs that go round fixtures, and of programs of the same parts that know nothing of them.

#include <gtest/gtest.h>

#include <set>
#include <span>
#include <sstream>

#include "config/job.h"
#include "daemon/plan/plan_program.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/collision/collision_check.h"
#include "sim/control/control_reader.h"
#include "sim/proof/convex_gap.h"
#include "tests/samples.h"
#include "tests/shapes/held_part.h"

namespace tiltfeed::sim {
namespace {

constexpr int kPlaces = 1000;
constexpr std::size_t kBlocks = 8;  ///< asked of each program, evenly; and no more besides
constexpr double kSure = 1e-6;      ///< mm, to which a distance is found

/// The point of a body that lies furthest along a direction.
using Furthest = std::function<Vec3(Vec3)>;

Vec3 rim(Vec3 axis, double radius, Vec3 along) {
  const Vec3 aside = along - axis * dot(along, axis);
  return length(aside) > 0.0 ? normalized(aside) * radius : Vec3{};
}

Furthest fixture(const config::SolidShape& shape) {
  if (shape.kind == config::SolidKind::kBox)
    return [=](Vec3 u) {
      const auto pick = [](double way, double half) { return way > 0.0 ? half : -half; };
      return shape.at + Vec3{pick(u.x, 0.5 * shape.size.x), pick(u.y, 0.5 * shape.size.y),
                             u.z > 0.0 ? shape.size.z : 0.0};
    };
  return [=](Vec3 u) {
    return shape.at + rim({0, 0, 1}, 0.5 * shape.diameter, u) + Vec3{0, 0, u.z > 0.0 ? shape.height : 0.0};
  };
}

/// The ball with the stem above it, or a step of the holder.
Furthest stem(Vec3 tip, Vec3 axis, double radius, double top) {
  return [=](Vec3 u) {
    const Vec3 ball = tip + axis * radius + normalized(u) * radius,
               disc = tip + axis * top + rim(axis, radius, u);
    return dot(u, ball) > dot(u, disc) ? ball : disc;
  };
}
Furthest step(Vec3 tip, Vec3 axis, double radius, double from, double to) {
  return [=](Vec3 u) { return tip + axis * (dot(u, axis) > 0.0 ? to : from) + rim(axis, radius, u); };
}

double distance(const Furthest& a, const Furthest& b) {
  const auto difference = [&](Vec3 u) { return a(-u) - b(u); };
  return gap_between(difference, {0.36, 0.48, 0.8}, kInfinity, kSure).width;
}

/// The least distance of tool and fixtures less what is asked of their pair, over all places of the move.
double least_room(const config::Job& job, const MoveFrames& frames, const ProgramMove& move) {
  const config::Clearances& c = job.machine.solid.clearances;
  const double factor = move.rapid ? c.rapid_factor : 1.0;
  std::vector<Furthest> held;
  for (const config::Fixture& one : job.fixtures) held.push_back(fixture(one.shape));
  double least = kInfinity;
  for (int i = 0; i < kPlaces; ++i) {
    const Pose pose = frames.pose(move, static_cast<double>(i) / (kPlaces - 1));
    const Vec3 tip = from_origin(pose.tip), axis = pose.axis;
    for (const Furthest& body : held) {
      least = std::min(least, distance(stem(tip, axis, 3.0, 30.0), body) - factor * c.cutter);
      least = std::min(least, distance(step(tip, axis, 10.0, 30.0, 60.0), body) - factor * c.holder);
      least = std::min(least, distance(step(tip, axis, 20.0, 60.0, 90.0), body) - factor * c.holder);
    }
  }
  return least;
}

bool is_tool(const std::string& body) {
  return body.starts_with("cutter") || body.starts_with("shank") || body.starts_with("holder");
}
bool hits_fixture(const Collisions& found) {
  return std::any_of(found.places.begin(), found.places.end(), [](const CollisionPlace& p) {
    return (p.first.starts_with("fixture") && is_tool(p.second)) ||
           (p.second.starts_with("fixture") && is_tool(p.first));
  });
}

std::vector<ProgramMove> moves_of(const config::Job& job, const std::string& program) {
  ControlReader reader(job.machine, job.setup);
  std::vector<ProgramMove> moves;
  std::istringstream text(file_text(program));
  std::vector<ControlBlock> blocks;
  for (std::string line; std::getline(text, line);) EXPECT_TRUE(reader.read_line(line, blocks)) << line;
  Joints at;
  for (const ControlBlock& one : blocks) {
    if (one.block.op != Op::kRapid && one.block.op != Op::kFeed) continue;
    if (!one.fresh)
      moves.push_back(
          {at, one.block.target, one.block.op == Op::kRapid, one.tcp, one.block.line, moves.size() + 1});
    at = one.block.target;
  }
  return moves;
}

/// Some blocks evenly, and those between which the verdict changes: they come nearest to what is asked.
std::set<std::size_t> asked(const std::vector<bool>& hits) {
  std::set<std::size_t> blocks;
  for (std::size_t i = 0; i < kBlocks; ++i) blocks.insert(i * hits.size() / kBlocks);
  for (std::size_t i = 1; i < hits.size() && blocks.size() < 2 * kBlocks; ++i)
    if (hits[i] != hits[i - 1]) blocks.insert({i - 1, i});
  return blocks;
}

struct Verdicts {
  int clear = 0, hit = 0;
};

/// Plans `planned` and holds the program against the fixtures of `held`.
void compare(const Folder& folder, HeldJob planned, const HeldJob& held, Verdicts& all) {
  planned.name += "_planned";
  daemon::PlanFiles files;
  files.job = write_held_job(folder, planned), files.program = folder.path + "/" + planned.name + ".nc";
  files.prove = false;
  const auto told = daemon::plan_program(files, {});
  ASSERT_TRUE(told) << told.error().message;
  const auto job = config::load_job(write_held_job(folder, held));
  ASSERT_TRUE(job) << job.error().message;
  const auto part = pathgen::check_mesh(*pathgen::read_stl(job->stl_path, 1.0));
  const auto check = CollisionCheck::make(*part, *job);
  ASSERT_TRUE(check) << check.error().message;
  const MoveFrames frames(job->machine.model, job->setup);
  const std::vector<ProgramMove> moves = moves_of(*job, files.program);
  std::vector<bool> hits;
  for (const ProgramMove& move : moves) hits.push_back(hits_fixture(check->hold(std::span(&move, 1), 0)));
  for (const std::size_t i : asked(hits)) {
    const ProgramMove& move = moves[i];
    const double room = least_room(*job, frames, move);
    const bool hit = hits[i];
    ++(hit ? all.hit : all.clear);
    // Two meshes of round bodies, the check's own error, and what lies between two places.
    const Pose from = frames.pose(move, 0.0), to = frames.pose(move, 1.0);
    const double between = (length(to.tip - from.tip) + 100.0 * length(to.axis - from.axis)) / kPlaces;
    if (hit)
      EXPECT_LE(room, kCollisionError + 0.02 + between) << held.name << ", line " << move.line;
    else
      EXPECT_GE(room, -2.0 * kSure) << held.name << ", line " << move.line;
  }
}

TEST(HeldPlaces, PlainDistancesAgreeWithTheCheck) {
  const Folder folder("held_places");
  const std::string fixed = "{mode: fixed, t: [1, 0, 0], n: [0, 0, 1]}";
  const std::string point =
      "{mode: point, sense: inward, origin_mm: [0, 0, 120], n: [0, 0, -1], t: [1, 0, 0]}";
  const std::string line = "{mode: line, sense: outward, origin_mm: [0, 0, 0], t: [0, 0, 1], n: [0, 1, 0]}";
  const std::vector<std::string> vice{box_fixture("left jaw", "60, 20, 30", "0, -25, -14"),
                                      box_fixture("right jaw", "60, 20, 30", "0, 25, -14")},
      studs{round_fixture("stud a", 10, 60, "-28, 0, 0"), round_fixture("stud b", 10, 60, "28, 6, 0")},
      jaws{box_fixture("jaw 1", "10, 30, 14", "16, 0, -4"), box_fixture("jaw 2", "10, 30, 14", "-16, 0, -4")};
  const std::vector<HeldJob> jobs{{"vice", "hill", fixed, vice},
                                  {"studs", "hill", fixed, studs},
                                  {"strap", "hill", fixed, {box_fixture("strap", "8, 50, 6", "0, 0, 20")}},
                                  {"vice_point", "hill", point, vice},
                                  {"studs_point", "hill", point, studs},
                                  {"chuck", "rod", line, jaws}};
  Verdicts round, through;
  for (const HeldJob& job : std::span(jobs).first(std::size_t{samples(6)})) {
    compare(folder, job, job, round);
    HeldJob blind = job;
    blind.fixtures = {box_fixture("far away", "1, 1, 1", "0, 0, -400")};
    compare(folder, blind, job, through);
  }
  EXPECT_EQ(round.hit, 0);
  EXPECT_GT(through.hit, samples(20));
  EXPECT_GT(through.clear, samples(20));
  std::printf("round fixtures: %d blocks clear; through them: %d clear, %d hit\n", round.clear, through.clear,
              through.hit);
}

}  // namespace
}  // namespace tiltfeed::sim
