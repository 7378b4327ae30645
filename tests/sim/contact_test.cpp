// The bounds that verification saves time by leave nothing out: depths against every facet at many poses,
// probes against a march along their lines.

#include "sim/removal/contact.h"

#include <algorithm>
#include <limits>
#include <random>

#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

/// Three rows over the plate, some of them too deep, with a wall beside the tool.
ExecutedPath rough_rows(const Job& job, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  ExecutedPath path;
  double time = 0.0;
  const auto go = [&](Point<Part> contact, double up, bool rapid) {
    const Vec3 u = normalized({0.3 * any(random), -0.5 + 0.2 * any(random), 1.0});
    const Joints to =
        joints_for({contact + Vec3{0, 0, job.plan.cutter.radius()} + u * (up - job.plan.cutter.radius()), u});
    path.moves.push_back({to, time, time + 1.0, 0.0, path.moves.size() + 1, 0, rapid}), time += 1.0;
  };
  go({-9, -3, 0}, 12.0, true);
  path.start = path.moves[0].to;
  for (double y = -3.0; y < 3.0; y += 2.0) {
    go({-7, y, 0}, 10.0, true);
    for (double x = -7.0; x <= 7.0; x += 0.9) go({x, y, 0.03 * any(random)}, 0.0, false);
    go({7, y, 0}, 10.0, true);
  }
  return path;
}

constexpr int kPoses = 40;

/// Every facet at many poses of every move.
std::array<double, 2> deepest(const Job& job, const ExecutedPath& path, const Mesh& part) {
  const PartDistance surface(part);
  const ToolSolid solid(job.plan.cutter);
  const FrameChain chain(job.machine.model, job.setup);
  std::array<double, 2> worst{};
  for (std::size_t m = 0; m < path.moves.size(); ++m)
    for (int k = 0; k <= kPoses; ++k) {
      const Pose pose = chain(between(path.from(m), path.moves[m].to, static_cast<double>(k) / kPoses));
      double& w = worst[path.moves[m].rapid ? 1 : 0];
      for (const ToolPart tool : kToolParts) w = std::max(w, -solid.clearance(surface, pose, tool, -w).value);
    }
  return worst;
}

// (removal.h, property 1)
TEST(Contact, DepthsAreThoseOfEveryFacetAtManyPoses) {
  Job job = make_job();
  const CheckedMesh part =
      checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-8, 4.8, -6}, Vec3{8, 8, 3}}}));
  Cutter holder = job.plan.cutter, flat = job.plan.cutter;
  holder.shank_length = 15.0, holder.cutting_length = 8.0, holder.holder = {{20.0, 24.0, 20.0}};
  flat.type = CutterType::kFlat;
  for (const Cutter& cutter : {job.plan.cutter, holder, flat}) {
    for (const std::uint32_t seed : {1u, 2u}) {
      job.plan.cutter = cutter;
      const ExecutedPath path = rough_rows(job, seed);
      Stock stock = *make_stock(*parse_stock("box:1"), part, job, 0.5, 1, {2});
      Probes probes(part.mesh, 0.1, 0.5);  // patches much smaller than the tool
      const auto found = remove_material(job, path, stock, probes, {job.plan.tolerance, 1}, {});
      ASSERT_TRUE(found);
      const auto expected = deepest(job, path, part.mesh);
      EXPECT_GT(expected[0], job.plan.tolerance);
      // Exact looks are half a radius apart where no ball is pushed along exactly.
      const double between_looks = cutter.type == CutterType::kFlat || !cutter.holder.empty() ? 0.05 : 1e-3;
      EXPECT_NEAR(found->worst[0], expected[0], between_looks) << seed;
      EXPECT_NEAR(found->worst[1], expected[1], 0.05 + 0.2 * expected[1]) << seed;
    }
  }
}

TEST(Contact, ProbesOfABallAgainstAMarchAlongTheirLines) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const CheckedMesh part = checked(box_mesh({{Vec3{-2, -2, -2}, Vec3{2, 2, 0}}}));
  constexpr double kReach = 0.5, kBall = 1.0, kStep = 2e-4;
  constexpr std::uint64_t kEvery = 19;
  int touched = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Probes probes(part.mesh, 0.05, kReach);  // patches much smaller than the ball
    const Point<Part> from{2 * any(random), 2 * any(random), 1.1 + 0.3 * any(random)};
    const BallWay way(from, from + Vec3{any(random), any(random), 0.3 * any(random)}, kBall);
    for (std::uint32_t patch = 0; patch < probes.patches().mesh.facets.size(); ++patch) {
      std::vector<Probes::Live> live;
      probes.collect(patch, live);
      probes.pass_ball(patch, way, 7, live);
      probes.settle(patch);
      for (std::uint64_t i = probes.patches().first[patch]; i < probes.patches().first[patch + 1];
           i += kEvery) {
        if (way.distance(probes.place(patch, i)) > kBall + kReach) continue;
        const Point<Part> p = probes.place(patch, i);
        double enter = kReach;
        for (double t = kReach; t > -2.0 * kBall; t -= kStep)
          if (way.distance(p + probes.patches().normal[patch] * t) < kBall) enter = t;
        const double inside = kBall - way.distance(p);
        const bool meets = enter < kReach && (enter >= 0.0 || inside > 0.0);
        const Probes::Value value = probes.value(i);
        if (std::abs(inside) < kStep || enter > kReach - 2.0 * kStep) continue;
        ASSERT_EQ(value.move != Probes::kNever, meets) << trial << ": " << enter << " " << inside;
        if (!meets) continue;
        ++touched;
        EXPECT_NEAR(value.left, enter >= 0.0 ? enter : std::max(enter, -inside), 2.0 * kStep) << trial;
        EXPECT_LE(value.left, probes.highest(patch));
      }
    }
  }
  EXPECT_GT(touched, 100);
}

// (removal.h, property 3)
TEST(Contact, ProbesOfRowsInAnyOrderAgainstTheirFormula) {
  constexpr double kWall = 4.8, kReach = 0.5;
  const CheckedMesh part =
      checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-8, kWall, -6}, Vec3{8, 8, 3}}}));
  const Job job = make_job();
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    struct Row {
      double y, height;
    };
    std::vector<Row> rows;
    for (int i = 0; i < 12; ++i) rows.push_back({-3.5 + 6.25 * any(random), 0.3 * any(random)});
    ExecutedPath path;
    const auto go = [&](double x, const Row& row, double up) {
      const double time = static_cast<double>(path.moves.size());
      path.moves.push_back({joints_for({{x, row.y, row.height + up}, {0, 0, 1}}), time, time + 1.0, 0.0,
                            path.moves.size() + 1, 0, false});
    };
    for (const Row& row : rows) {
      go(-9.0, row, 5.0);
      for (double x = -9.0; x <= 9.0; x += 0.3 + any(random)) go(x, row, 0.0);
      go(9.0, row, 0.0), go(9.0, row, 5.0);
    }
    path.start = path.moves[0].to;
    Stock stock = *make_stock(*parse_stock("box:1"), part, job, 0.5, 1, {2});
    Probes probes(part.mesh, 0.05, kReach);  // patches much smaller than the tool
    ASSERT_TRUE(remove_material(job, path, stock, probes, {job.plan.tolerance, 2}, {}));
    std::array<int, 2> near{}, far{};
    for (std::uint32_t patch = 0; patch < probes.patches().mesh.facets.size(); ++patch) {
      const Vec3 n = probes.patches().normal[patch];
      for (std::uint64_t i = probes.patches().first[patch]; i < probes.patches().first[patch + 1]; ++i) {
        const Point<Part> p = probes.place(patch, i);
        const bool top = n.z > 0.5 && p.y < 4.0, wall = n.y < -0.5 && p.y > 4.0;
        if ((!top && !wall) || std::abs(p.x) > 6.5) continue;
        double left = kInfinity;
        for (const Row& row : rows) {
          // Beside the row, or below the ball's centre, of which the shank stands straight up.
          const double off = top ? p.y - row.y : std::max(0.0, row.height + kRadius - p.z);
          if (std::abs(off) >= kRadius) continue;
          const double ball = std::sqrt(kRadius * kRadius - off * off);
          left = std::min(left, top ? row.height + kRadius - ball : kWall - row.y - ball);
        }
        if (std::abs(left - kReach) < 1e-5) continue;
        const Probes::Value value = probes.value(i);
        ++(left < kReach ? near : far)[top ? 0 : 1];
        ASSERT_EQ(value.move != Probes::kNever, left < kReach) << seed << ": " << to_string(p) << left;
        if (left >= kReach) continue;
        ASSERT_NEAR(value.left, left, 1e-5) << seed << ": " << to_string(p);
      }
    }
    EXPECT_GT(std::min(near[0], far[1]), 1000);
  }
}

TEST(Contact, ALedgeAtAnyHeightIsCutAsDeepAsTheShankGoes) {
  constexpr double kDeep = 0.3, kWall = 5.0;
  const Job job = make_job();
  for (double height = 1.0; height < 30.0; height += 0.5) {
    // Large patches, which reach over more than one stretch of the shank.
    const CheckedMesh part = checked(
        box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, -1}}, {Vec3{-8, kWall, height}, Vec3{8, 8, height + 3.5}}}));
    ExecutedPath path;
    const auto go = [&](double x, double up) {
      const double time = static_cast<double>(path.moves.size());
      path.moves.push_back({joints_for({{x, kWall - kRadius + kDeep, up}, {0, 0, 1}}), time, time + 1.0, 0.0,
                            path.moves.size() + 1, 0, false});
    };
    go(-12.0, 0.0);
    for (double x = -11.0; x <= 12.0; x += 0.7) go(x, 0.0);
    path.start = path.moves[0].to;
    Stock stock = *make_stock(*parse_stock("box:1"), part, job, 0.5, 1, {2});
    Probes probes(part.mesh, 0.5, 0.5);
    const auto found = remove_material(job, path, stock, probes, {job.plan.tolerance, 1}, {});
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->worst[0], kDeep, 1e-6) << height;
    EXPECT_NEAR(found->deepest, -kDeep, 1e-6) << height;
  }
}

/// Rows near each other over a plate, beside a wall; the axis turns by up to `turn` in a move. The first path
/// is all of them in a row, the others are its parts.
std::vector<ExecutedPath> neighbours(double turn) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<ExecutedPath> paths(1);
  const auto add = [&](const Joints& to, ExecutedPath& path) {
    if (path.moves.empty()) path.start = to;
    path.moves.push_back({to, 0.0, 1.0, 0.0, 1, 0, false});
  };
  for (double y = -1.0; y < 2.9; y += 0.15) {
    ExecutedPath row, link;
    if (!paths[0].moves.empty()) add(paths[0].moves.back().to, link);
    const Vec3 lean{0.1 + 2.0 * turn * any(random), -0.5 + turn * any(random), 1.0};
    for (double x = -7.0; x <= 7.0; x += 0.6) {
      const Vec3 u = normalized(lean + Vec3{turn * any(random), turn * any(random), 0.0});
      const Point<Part> centre{x, y + 0.05 * any(random), kRadius + 0.1 + 0.1 * any(random)};
      const Joints to = joints_for({centre - u * kRadius, u});
      add(to, row), add(to, paths[0]);
    }
    add(row.start, link);
    paths.push_back(row), paths.push_back(link);
  }
  return paths;
}

// (removal.h, property 3)
TEST(Contact, ProbesOfNeighbouringRowsAreThoseOfEachRowByItself) {
  const CheckedMesh part =
      checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-8, 4.8, -6}, Vec3{8, 8, 3}}}));
  const Job job = make_job();
  // What a piece sweeps while it turns is right to an eighth of a cell only, (W4); here to a fiftieth.
  for (const auto& [turn, error] : {std::pair(0.0, 1e-6), std::pair(0.05, 0.01)}) {
    const std::vector<ExecutedPath> paths = neighbours(turn);
    for (const double spacing : {0.05, 0.3}) {
      // Each path has its own: they note its moves by number.
      std::vector<Probes> probes;
      for (const ExecutedPath& path : paths) {
        Stock stock = *make_stock(*parse_stock("box:1"), part, job, 0.5, 1, {2});
        probes.emplace_back(part.mesh, spacing, 0.5);
        ASSERT_TRUE(remove_material(job, path, stock, probes.back(), {job.plan.tolerance, 1}, {}));
      }
      const Probes& together = probes.front();
      std::uint64_t touched = 0;
      for (std::uint64_t i = 0; i < together.count(); ++i) {
        const double left = together.value(i).left;
        double by_itself = std::numeric_limits<double>::infinity();
        for (std::size_t k = 1; k < probes.size(); ++k)
          by_itself = std::min(by_itself, probes[k].value(i).left);
        ASSERT_EQ(std::isfinite(left), std::isfinite(by_itself)) << turn << " " << spacing << " " << i;
        if (!std::isfinite(left)) continue;
        ASSERT_NEAR(left, by_itself, error) << turn << " " << spacing << " " << i;
        ++touched;
      }
      EXPECT_GT(touched, together.count() / 10);
    }
  }
}

TEST(Contact, AGrazeOverASharpEdgeIsNoGouge) {
  Shop shop;
  for (const double deep : {0.004, 0.02}) {
    shop.lines = {"G21 G90 G94"};
    const Vec3 up{0, 0, 1};
    for (double y = -4.0; y <= 4.0; y += 0.4) {
      shop.move("G0", {{-10, y, 5}, up});
      shop.move("G1", {{-10, y, -deep}, up});
      shop.move("G1", {{10, y, -deep}, up});
      shop.move("G0", {{10, y, 5}, up});
    }
    const auto [removal, verdict] = shop.run(0.1, 2, "box:1");
    EXPECT_EQ(first_of(removal, TroubleKind::kGouge) == nullptr, deep < 0.01);
    EXPECT_NEAR(verdict.gouge, deep, 1e-4);
  }
}

TEST(Contact, TimesAreThoseOfTheControlThatTheProfileStates) {
  const Shop shop;
  std::string text;
  for (const std::string& line : shop.lines) text += line + "\n";
  const auto seconds = [&](const MotionOptions& options) {
    std::istringstream in(text);
    return execute_program(*read_program(in, "p.nc", 'A', 'C'), "p.nc", shop.job.machine.model,
                           shop.job.setup, options)
        ->seconds;
  };
  MotionOptions blind, far;
  blind.look_ahead = 1, far.look_ahead = 200;
  EXPECT_GT(seconds(blind), 1.05 * seconds(far));
}

}  // namespace
}  // namespace tiltfeed::sim
