// sim/verify: a small job whose path, joints and contact are known in closed form passes; every kind of
// damage to it is found, with its size and place.

#include "sim/path_check/path_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/shapes/box_mesh.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

/// A plate 60 x 40 with its top at z = 0.
Mesh plate() { return box_mesh({{Vec3{-30, -20, -10}, Vec3{30, 20, 0}}}); }

Vec3 axis_over(double x, double y) { return normalized({0.2 + 0.004 * x, -0.5 + 0.003 * y, 1.0}); }

/// The ball touches z = 0 at (x, y), lifted by `lift`.
Pose touching(double x, double y, double lift = 0.0) {
  const Vec3 axis = axis_over(x, y);
  return {Point<Part>{x, y, kRadius + lift} - axis * kRadius, axis};
}

/// Five passes along x, 2 mm apart, in steps of 0.25 mm, each with plunge, retract and rapid.
ToolPath make_path() {
  ToolPath path;
  path.tool = {2 * kRadius, kRadius, 100.0};
  path.cut_feed = Feed::from_mm_per_min(600), path.plunge_feed = Feed::from_mm_per_min(300);
  const auto lifted = [](Pose p, double by) { return Pose{p.tip + p.axis * by, p.axis}; };
  for (int pass = 0; pass < 5; ++pass) {
    const double y = -4.0 + 2.0 * pass;
    for (int i = 0; i <= 80; ++i) {
      const Pose pose = touching((pass % 2 == 0 ? 1 : -1) * (-10.0 + 0.25 * i), y);
      if (i == 0) {
        path.moves.push_back({lifted(pose, 12), MoveKind::kRapid});
        path.moves.push_back({lifted(pose, 2), MoveKind::kRapid});
        path.moves.push_back({pose, MoveKind::kPlunge});
      } else {
        path.moves.push_back({pose, MoveKind::kCut});
      }
      if (i == 80) path.moves.push_back({lifted(pose, 12), MoveKind::kRapid});
    }
  }
  return path;
}

/// One block a move; `executed` may differ from the path.
std::vector<Block> program_for(const std::vector<Move>& executed) {
  std::vector<Block> program;
  Block spindle;
  spindle.op = Op::kMCode, spindle.m_code = 3;
  program.push_back(spindle);
  for (const Move& move : executed) {
    Block block;
    block.op = move.kind == MoveKind::kRapid ? Op::kRapid : Op::kFeed;
    block.inverse_time = block.op == Op::kFeed;
    block.feed = block.inverse_time ? 2400.0 : 0.0;
    block.target = joints_for(move.pose);
    block.line = static_cast<std::uint32_t>(program.size() + 10);
    program.push_back(block);
  }
  spindle.m_code = 2;
  program.push_back(spindle);
  return program;
}

std::vector<TraceRow> run_of(const std::vector<Block>& program) {
  std::vector<TraceRow> trace;
  for (const Block& block : program) {
    TraceRow row;
    row.block = trace.size() + 1, row.command = block;
    row.start = trace.empty() ? 0.0 : trace.back().end;
    row.end = row.start + (block.op == Op::kFeed ? 0.025 : block.op == Op::kRapid ? 0.5 : 0.0);
    trace.push_back(row);
  }
  return trace;
}

PathCheckReport check(const std::vector<Move>& executed, const Mesh& part = plate(), int threads = 2) {
  const auto program = program_for(executed);
  PathCheckOptions options;
  options.threads = threads;
  const ToolPath path = make_path();
  auto report = check_path(make_job(), part, program, path, run_of(program), options, {});
  EXPECT_TRUE(report.has_value()) << report.error().message;
  return report ? *report : PathCheckReport{};
}

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(Verify, GoodRunPassesWithTheKnownFigures) {
  const PathCheckReport r = check(make_path().moves);
  EXPECT_TRUE(r.passed()) << all(r.failures);
  EXPECT_TRUE(r.program.good());
  EXPECT_EQ(r.program.blocks, 5u * 84 + 2);
  // Chords of 0.25 mm: joints move linearly, so the ball is off by micrometres, not by nothing (K6).
  EXPECT_LT(r.tip_deviation.value, 0.002);
  EXPECT_GT(r.tip_deviation.value, 1e-7);
  EXPECT_LT(r.missed_point.value, 1e-9);
  EXPECT_LT(r.axis_deviation.value, 0.01);
  EXPECT_LT(r.gouge.value, 0.002);
  EXPECT_LT(r.gap.value, 0.002);
  EXPECT_LT(r.rapid_overlap.value, 1e-6);
  EXPECT_GE(r.drop.value, r.gap.value);
  EXPECT_LE(r.drop_999, r.drop.value);
  // At a corner a sample counts for the one move or the other.
  EXPECT_NEAR(r.plunge_length, 5 * 2.0, 0.2);
  double cut = 0.0;
  const ToolPath path = make_path();
  for (std::size_t i = 1; i < path.moves.size(); ++i)
    if (path.moves[i].kind == MoveKind::kCut)
      cut += distance(path.moves[i - 1].pose.tip, path.moves[i].pose.tip);
  EXPECT_NEAR(r.cut_length + r.plunge_length, cut + 10.0, 0.01);
  EXPECT_NEAR(r.seconds, 5 * (81 * 0.025 + 3 * 0.5) - 0.5, 1e-9);
  EXPECT_GE(r.cut_samples, 5u * 79 * 5);
}

TEST(Verify, SameReportForAnyNumberOfThreads) {
  auto moves = make_path().moves;
  moves[200].pose = touching(1.0, 0.0, -0.3);
  EXPECT_EQ(to_json(check(moves, plate(), 1)), to_json(check(moves, plate(), 3)));
}

TEST(Verify, GougeIsFoundWithDepthBlockAndFacet) {
  auto moves = make_path().moves;
  ASSERT_EQ(moves[40].kind, MoveKind::kCut);
  moves[40].pose.tip = moves[40].pose.tip - Vec3{0, 0, 0.05};
  const PathCheckReport r = check(moves);
  EXPECT_FALSE(r.passed());
  EXPECT_NEAR(r.gouge.value, 0.05, 0.002);
  EXPECT_EQ(r.gouge.place.block, 42u);  // row 1 is M3
  EXPECT_EQ(r.gouge.place.line, 51u);
  EXPECT_EQ(r.gouge.place.move, 40u);
  EXPECT_TRUE(r.gouge.place.facet == 1002 || r.gouge.place.facet == 1003) << r.gouge.place.facet;
  EXPECT_NEAR(r.tip_deviation.value, 0.05, 0.002);
  EXPECT_NE(all(r.failures).find("part gouged by 0.05"), std::string::npos) << all(r.failures);
}

TEST(Verify, AllowanceCountsAsPart) {
  Job job = make_job();
  job.plan.allowance = 0.2;
  const ToolPath path = make_path();
  const auto program = program_for(path.moves);
  const auto r = check_path(job, plate(), program, path, run_of(program), {}, {});
  ASSERT_TRUE(r);
  EXPECT_NEAR(r->gouge.value, 0.2, 0.002);
}

TEST(Verify, CuttingInTheAirIsFound) {
  auto moves = make_path().moves;
  moves[150].pose.tip = moves[150].pose.tip + Vec3{0, 0, 0.04};
  const PathCheckReport r = check(moves);
  EXPECT_NEAR(r.gap.value, 0.04, 0.002);
  // Along an axis tilted by tau the ball drops 1 / cos tau as far.
  EXPECT_NEAR(r.drop.value, 0.04 / moves[150].pose.axis.z, 0.002);
  EXPECT_FALSE(r.passed());
}

TEST(Verify, PlanInTheAirIsFound) {
  // The path itself is too high and the machine follows it well.
  ToolPath path = make_path();
  for (Move& move : path.moves) move.pose.tip = move.pose.tip + Vec3{0, 0, 0.03};
  const auto program = program_for(path.moves);
  const auto r = check_path(make_job(), plate(), program, path, run_of(program), {}, {});
  ASSERT_TRUE(r);
  EXPECT_LT(r->tip_deviation.value, 0.002);
  EXPECT_EQ(r->air_samples, r->cut_samples);
  ASSERT_EQ(r->failures.size(), 1u) << all(r->failures);
  EXPECT_NE(r->failures[0].find("in the air"), std::string::npos) << r->failures[0];
}

TEST(Verify, RapidThroughThePartIsFound) {
  auto moves = make_path().moves;
  ASSERT_EQ(moves[83].kind, MoveKind::kRapid);  // retract left out: on to the next pass along the surface
  moves.erase(moves.begin() + 83);
  moves[83].pose.tip = moves[83].pose.tip - Vec3{0, 0, 14};
  const PathCheckReport r = check(moves);
  EXPECT_GT(r.rapid_overlap.value, 1.0);
  EXPECT_NE(all(r.failures).find("rapid cuts into the part"), std::string::npos) << all(r.failures);
}

TEST(Verify, ShankAgainstAWallIsFound) {
  // The tool leans towards +x; the wall's near face is where the shank's side gets at the top.
  const Mesh part = box_mesh({{Vec3{-30, -20, -10}, Vec3{30, 20, 0}}, {Vec3{16, -30, 4}, Vec3{18, 30, 60}}});
  EXPECT_LT(check(make_path().moves).gouge.value, 0.002);
  const PathCheckReport r = check(make_path().moves, part);
  EXPECT_NEAR(r.gouge.value, kRadius, 1e-9);  // the axis itself pierces the wall
  EXPECT_GE(r.gouge.place.facet, 1012u);
}

/// A bull-nose with a thinner shank and a holder; the path lets it touch z = 0 where the ball would.
Job bull_job() {
  Job job = make_job();
  job.plan.cutter.type = CutterType::kBullNose, job.plan.cutter.corner_radius = 0.5;
  job.plan.cutter.cutting_length = 8.0, job.plan.cutter.shank_diameter = 3.0;
  job.plan.cutter.holder = {{20.0, 24.0, 30.0}};
  return job;
}

ToolPath bull_path() {
  ToolPath path = make_path();
  const double c = 0.5, e = kRadius - c;
  for (Move& move : path.moves) {
    // Above z = 0 the ball's tip is at kRadius (1 - cos), the bull-nose's at e sin + c (1 - cos).
    const double up = move.pose.axis.z, lean = std::sqrt(1 - up * up);
    move.pose.tip = move.pose.tip + Vec3{0, 0, e * lean + c * (1 - up) - kRadius * (1 - up)};
  }
  return path;
}

PathCheckReport check_bull(const Job& job, const Mesh& part) {
  const ToolPath path = bull_path();
  const auto program = program_for(path.moves);
  const auto report = check_path(job, part, program, path, run_of(program), {}, {});
  EXPECT_TRUE(report.has_value());
  return report ? *report : PathCheckReport{};
}

TEST(Verify, JudgesWithTheTrueCutter) {
  const PathCheckReport r = check_bull(bull_job(), plate());
  EXPECT_TRUE(r.passed()) << all(r.failures);
  EXPECT_LT(r.gouge.value, 0.002);
  EXPECT_LT(r.gap.value, 0.002);
  EXPECT_EQ(r.air_samples, 0u);
  // A flat end of the same diameter on that path gouges, a ball hangs in the air.
  Job other = bull_job();
  other.plan.cutter.type = CutterType::kFlat;
  EXPECT_GT(check_bull(other, plate()).gouge.value, 0.1);
  other.plan.cutter.type = CutterType::kBall;
  EXPECT_GT(check_bull(other, plate()).gap.value, 0.1);
  other = bull_job(), other.plan.axial_stock = 0.1;
  const double down = check_bull(other, plate()).gouge.value;
  EXPECT_GT(down, 0.08 * std::sqrt(0.5));
  EXPECT_LT(down, 0.1);
}

TEST(Verify, ShankAndHolderCountForThemselves) {
  // Bars square to the lean: one reaches the holder only, one the shank only.
  const Vec3 axis = axis_over(0, 0);
  for (const bool holder : {true, false}) {
    const double height = holder ? 55.0 : 25.0, radius = holder ? 11.0 : 1.5;
    const Point<Part> at = Point<Part>{} + axis * height;
    const double edge = at.x + radius - 1.0;
    const Mesh part = box_mesh({{Vec3{-30, -20, -10}, Vec3{30, 20, 0}},
                                {Vec3{edge, at.y - 1, at.z - 0.5}, Vec3{edge + 40, at.y + 1, at.z + 0.5}}});
    const PathCheckReport r = check_bull(bull_job(), part);
    const auto deepest = [&](ToolPart tool) { return r.gouge_by[static_cast<int>(tool)].value; };
    EXPECT_LT(deepest(ToolPart::kCutter), 0.002);
    EXPECT_GT(deepest(holder ? ToolPart::kHolder : ToolPart::kShank), 0.5);
    EXPECT_LT(deepest(holder ? ToolPart::kShank : ToolPart::kHolder), holder ? 1e-9 : kRadius);
    EXPECT_EQ(r.gouge.value, std::max(deepest(ToolPart::kHolder), deepest(ToolPart::kShank)));
    EXPECT_NE(all(r.failures).find(holder ? ", holder) at" : ", shank) at"), std::string::npos)
        << all(r.failures);
  }
}

TEST(Verify, StartInsideThePartIsFound) {
  const Mesh part = box_mesh({{Vec3{-300, -300, -300}, Vec3{300, 300, 300}}});
  const PathCheckReport r = check(make_path().moves, part);
  EXPECT_FALSE(r.passed());
  EXPECT_EQ(r.rapid_overlap.value, kRadius);
}

TEST(Verify, SkippedPointsAreMissed) {
  auto moves = make_path().moves;
  // A whole pass left out: the tool goes from the end of the second straight to the third's end.
  moves.erase(moves.begin() + 170, moves.begin() + 250);
  const PathCheckReport r = check(moves);
  EXPECT_GT(r.missed_point.value, 1.0);
  EXPECT_NE(all(r.failures).find("planned point missed"), std::string::npos) << all(r.failures);
  // One point of a straight row left out is no harm: the track passes it.
  auto thinned = make_path().moves;
  thinned.erase(thinned.begin() + 40);
  EXPECT_TRUE(check(thinned).passed()) << all(check(thinned).failures);
}

TEST(Verify, WrongAxisIsFound) {
  auto moves = make_path().moves;
  // Same ball centre, axis 1 degree off: neither gouge nor gap show it.
  Pose& pose = moves[300].pose;
  const Point<Part> centre = pose.tip + pose.axis * kRadius;
  pose.axis = rotation_about({1, 0, 0}, kPi / 180.0) * pose.axis;
  pose.tip = centre - pose.axis * kRadius;
  const PathCheckReport r = check(moves);
  EXPECT_NEAR(r.axis_deviation.value, 1.0, 0.02);
  EXPECT_EQ(r.axis_deviation.place.move, 300u);
}

TEST(BlockComparison, TellsMissingRepeatedAndAltered) {
  const auto program = program_for(make_path().moves);
  const auto good = run_of(program);
  EXPECT_TRUE(compare_blocks(program, good).good());
  struct Expected {
    std::uint64_t missing, repeated, altered;
  };
  const auto expect = [&](const std::vector<TraceRow>& trace, Expected e, const char* place) {
    const BlockComparison check = compare_blocks(program, trace);
    EXPECT_EQ(check.missing, e.missing) << check.first_difference;
    EXPECT_EQ(check.repeated, e.repeated) << check.first_difference;
    EXPECT_EQ(check.altered, e.altered) << check.first_difference;
    EXPECT_NE(check.first_difference.find(place), std::string::npos) << check.first_difference;
  };
  auto trace = good;
  trace.erase(trace.begin() + 100, trace.begin() + 103);
  expect(trace, {3, 0, 0}, "block 101 of the program");
  trace = good;
  trace.insert(trace.begin() + 101, good.begin() + 99, good.begin() + 101);
  expect(trace, {0, 2, 0}, "block 102 of the program");
  trace = good;
  trace[100].command.target.y += 1e-4;
  expect(trace, {0, 0, 1}, "block 101 of the program");
  trace = good;
  trace[100].command.feed *= 2.0;
  expect(trace, {0, 0, 1}, "block 101 of the program");
  trace = good;
  trace[2].command.op = Op::kFeed, trace[300].command.op = Op::kRapid;
  expect(trace, {0, 0, 2}, "block 3 of the program");
  trace = good;
  trace.front().command.m_code = 4;
  expect(trace, {0, 0, 1}, "M3");
  trace = good;
  trace.resize(200);
  expect(trace, {program.size() - 200, 0, 0}, "block 201 of the program");
  trace = good;
  trace.push_back(good.back());
  expect(trace, {0, 1, 0}, "(its end)");
  TraceRow barrier = good.back();
  barrier.command.op = Op::kDwell, barrier.command.feed = 0.0;
  trace = good;
  trace.push_back(barrier);  // the host's own, once, at the end
  EXPECT_TRUE(compare_blocks(program, trace).good());
  EXPECT_EQ(compare_blocks(program, trace).executed, good.size());
  trace.push_back(barrier);
  expect(trace, {0, 2, 0}, "(its end)");
  trace = good;
  trace.insert(trace.begin() + 100, barrier);
  expect(trace, {0, 1, 0}, "block 101 of the program");
  trace = good;
  std::swap(trace[50], trace[51]);
  EXPECT_FALSE(compare_blocks(program, trace).good());
  trace = good;  // lost once, repeated elsewhere: the counts stay apart
  trace.insert(trace.begin() + 300, good[299]), trace.erase(trace.begin() + 20);
  expect(trace, {1, 1, 0}, "block 21 of the program");
}

TEST(Verify, JsonReadsBack) {
  auto moves = make_path().moves;
  moves[40].pose.tip = moves[40].pose.tip - Vec3{0, 0, 0.05};
  const PathCheckReport r = check(moves);
  const auto json = nlohmann::json::parse(to_json(r));
  EXPECT_FALSE(json["passed"].get<bool>());
  EXPECT_EQ(json["failures"].size(), r.failures.size());
  EXPECT_EQ(json["gouge_mm"]["value"].get<double>(), r.gouge.value);
  EXPECT_EQ(json["gouge_mm"]["block"].get<int>(), 42);
  EXPECT_EQ(json["program"]["blocks"].get<std::uint64_t>(), r.program.blocks);
}

TEST(Verify, NothingToVerifyIsAnError) {
  const ToolPath path = make_path();
  const auto program = program_for(path.moves);
  EXPECT_FALSE(check_path(make_job(), plate(), program, path, {}, {}, {}));
  EXPECT_FALSE(check_path(make_job(), plate(), program, ToolPath{}, run_of(program), {}, {}));
  EXPECT_FALSE(check_path(make_job(), Mesh{}, program, path, run_of(program), {}, {}));
  const auto cancelled = check_path(make_job(), plate(), program, path, run_of(program), {},
                                    [](const char*, double) { return false; });
  EXPECT_FALSE(cancelled);
}

}  // namespace
}  // namespace tiltfeed::sim
