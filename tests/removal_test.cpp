// Material removal: four cuts known in closed form; a clean program passes, and each kind of damage to it is
// found, with its size and place.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "sim/forward.h"
#include "sim/removal.h"
#include "sim/removal_report.h"
#include "sim/tool_sweep.h"
#include "tests/box_mesh.h"

namespace tiltfeed::sim {
namespace {

constexpr double kRadius = 2.0, kPivot = 150.0;

CheckedMesh checked(const Mesh& mesh) {
  CheckedMesh part;
  part.mesh = mesh;
  part.bounds = {mesh.vertices[0], mesh.vertices[0]};
  for (const Point<Part> p : mesh.vertices) part.bounds = grown(part.bounds, p);
  return part;
}

Job make_job() {
  Job job;
  job.path = "test.yaml";
  job.plan.name = "plate";
  job.plan.cutter = {2 * kRadius, 100.0, 40.0};
  job.plan.tolerance = 0.01;
  job.plan.pattern.side_step = 0.4;
  job.plan.links.approach = 1.0;
  MachineModel& m = job.machine.model;
  m.name = "test";
  for (LinearAxis* axis : {&m.x, &m.y, &m.z}) *axis = {-500, 500, 60000, 1000};
  m.tilt = {'A', {1, 0, 0}, +1, 0, -110, 110, 36000, 1000};
  m.rotary = {'C', {0, 0, 1}, -1, 0, -36000, 36000, 36000, 1000};
  m.pivot_to_gauge = {0, 0, -(kPivot - 100.0)};
  job.setup.tool_length = 100.0;
  return job;
}

// --- Cuts known in closed form -------------------------------------------------------------------------

/// A block of stock from (-10, -10, -10) to (10, 10, 0), nothing of a part.
Stock block(double cell) {
  const Box box{{-10, -10, -10}, {10, 10, 0}};
  Stock stock{{}, box, cell};
  for (int axis = 0; axis < 3; ++axis) {
    stock.bundles.emplace_back(axis, box, cell);
    for (int s = 0; s < Dexels::kStripes; ++s)
      stock.bundles.back().fill(s, box), stock.bundles.back().settle(s);
  }
  return stock;
}

void cut(Stock& stock, const Cutter& cutter, const Pose& from, const Pose& to) {
  const ToolSweep sweep(cutter);
  std::vector<SweptBody> bodies;
  sweep.bodies(
      from, to, [](Point<Part>) { return true; }, bodies);
  for (Dexels& dexels : stock.bundles)
    for (int s = 0; s < Dexels::kStripes; ++s)
      for (const SweptBody& body : bodies) dexels.cut(s, body, false);
}

/// Largest distance of the stock's new borders from where `left` (signed: above 0 is material) is zero, and
/// of the stock's middles and gaps from being on their sides; the least number of new borders seen.
struct Compared {
  double border = 0.0;
  std::size_t borders = 0;
};
template <class Left>
Compared compare(const Stock& stock, const Left& left, double low, double high) {
  Compared result;
  for (const Dexels& dexels : stock.bundles) {
    for (int s = 0; s < Dexels::kStripes; ++s) {
      dexels.each(s, [&](Point<Part> foot, double from, double to) {
        std::array<double, 3> p{foot.x, foot.y, foot.z};
        const auto at = [&](double t) {
          p[dexels.axis()] = t;
          return left(Point<Part>{p[0], p[1], p[2]});
        };
        // No material where there must be none; every end inside of the block lies on the cut's surface.
        for (int i = 0; i <= 8; ++i)
          result.border = std::max(result.border, -at(from + (to - from) * i / 8.0));
        const double edge_low = dexels.axis() == 2 ? -10.0 : low, edge_high = dexels.axis() == 2 ? 0.0 : high;
        for (const double t : {from, to})
          if (t > edge_low + 1e-3 && t < edge_high - 1e-3)
            result.border = std::max(result.border, std::abs(at(t))), ++result.borders;
      });
    }
  }
  return result;
}

TEST(Removal, GrooveOfABallInAPlane) {
  for (const double cell : {0.5, 0.2}) {
    Stock stock = block(cell);
    cut(stock, {6, 100, 40}, {{-20, 0, -1.5}, {0, 0, 1}}, {{20, 0, -1.5}, {0, 0, 1}});
    const auto left = [](Point<Part> p) { return p.z > 1.5 ? -1.0 : std::hypot(p.y, p.z - 1.5) - 3.0; };
    const Compared c = compare(stock, left, -10, 10);
    EXPECT_LE(c.border, 2 * Dexels::kUnit) << cell;
    EXPECT_GT(c.borders, 100u);
    // The segment of the circle that lies below the plane, times the length; within half a cell over the cut.
    const double half = std::acos(1.5 / 3.0), area = 9.0 * (half - std::sin(half) * std::cos(half));
    EXPECT_NEAR(4000.0 - stock.volume(), area * 20.0, 0.5 * cell * 2 * half * 3.0 * 20.0 * 0.25) << cell;
  }
}

TEST(Removal, SlotOfAFlatMill) {
  Cutter flat{4, 100, 40};
  flat.type = CutterType::kFlat;
  for (const double cell : {0.5, 0.2}) {
    Stock stock = block(cell);
    cut(stock, flat, {{-20, 0.1, -2}, {0, 0, 1}}, {{20, 0.1, -2}, {0, 0, 1}});
    const auto left = [](Point<Part> p) { return std::max(std::abs(p.y - 0.1) - 2.0, -2.0 - p.z); };
    const Compared c = compare(stock, left, -10, 10);
    EXPECT_LE(c.border, 0.5 * cell);
    EXPECT_LE(c.border, 2e-5) << cell;
    EXPECT_NEAR(4000.0 - stock.volume(), 4.0 * 2.0 * 20.0, 0.5 * cell * 8.0 * 20.0) << cell;
  }
}

TEST(Removal, SphereCavity) {
  for (const double cell : {0.5, 0.2}) {
    Stock stock = block(cell);
    Cutter ball{8, 100, 4.0};
    cut(stock, ball, {{0.3, 0.2, -9}, {0, 0, 1}}, {{0.3, 0.2, -9}, {0, 0, 1}});
    const auto left = [](Point<Part> p) { return distance(p, Point<Part>{0.3, 0.2, -5}) - 4.0; };
    const Compared c = compare(stock, left, -10, 10);
    EXPECT_LE(c.border, 2 * Dexels::kUnit) << cell;
    EXPECT_GT(c.borders, 100u);
    EXPECT_NEAR(4000.0 - stock.volume(), 4.0 / 3.0 * kPi * 64.0, 0.5 * cell * 4.0 * kPi * 16.0) << cell;
  }
}

TEST(Removal, BarTurnedByTheTable) {
  // A thin core stands for the part; the bar of radius 9 is turned to radius 6 by one turn of C.
  const Job job = make_job();
  const CheckedMesh part = checked(box_mesh({{Vec3{-1, -1, -10}, Vec3{1, 1, 0}}}));
  for (const double cell : {0.5, 0.2}) {
    const auto shape = parse_stock("cylinder:" + std::to_string(9.0 - std::sqrt(2.0)));
    ASSERT_TRUE(shape);
    auto stock = make_stock(*shape, part, job, cell, 2);
    ASSERT_TRUE(stock) << stock.error().message;
    const auto program = [] {
      std::istringstream in("G21 G90 G94\nG0 X20 Y0 Z-30 A0 C0\nG1 X8 F1000\nC360 F3000\nG0 X20\nM2\n");
      return read_program(in, "p.nc", 'A', 'C');
    }();
    ASSERT_TRUE(program);
    const auto path = execute_program(*program, "p.nc", job.machine.model, job.setup);
    ASSERT_TRUE(path);
    Probes probes(part.mesh, cell, 0.5);
    const auto cut = remove_material(job, *path, *stock, probes, {}, {});
    ASSERT_TRUE(cut);
    double worst = 0.0;
    std::size_t seen = 0;
    for (const Dexels& dexels : stock->bundles) {
      for (int s = 0; s < Dexels::kStripes; ++s)
        dexels.each(s, [&](Point<Part> foot, double from, double to) {
          std::array<double, 3> p{foot.x, foot.y, foot.z};
          for (const double t : {from, to}) {
            p[dexels.axis()] = t;
            // The flanks reach from -30 + radius up; ends on the bar's own faces are not of the cut.
            if (std::abs(p[2] + 10.0 + 9.0 - std::sqrt(2.0)) < 0.5 || p[2] > 6.5) continue;
            worst = std::max(worst, std::abs(std::hypot(p[0], p[1]) - 6.0)), ++seen;
          }
        });
    }
    EXPECT_LE(worst, 0.125 * cell + 1e-3) << cell;
    EXPECT_GT(seen, 100u);
  }
}

// --- A clean program, and damage to it -----------------------------------------------------------------

Joints joints_for(const Pose& p) {
  const double a = std::atan2(std::hypot(p.axis.x, p.axis.y), p.axis.z), c = std::atan2(p.axis.x, -p.axis.y);
  return {std::cos(c) * p.tip.x + std::sin(c) * p.tip.y,
          -std::sin(c) * p.tip.x + std::cos(c) * p.tip.y - kPivot * std::sin(a),
          p.tip.z + kPivot * (std::cos(a) - 1.0), a * 180.0 / kPi, c * 180.0 / kPi};
}

struct Shop {
  Job job = make_job();
  CheckedMesh part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}}));
  std::vector<std::string> lines{"G21 G90 G94"};
  std::vector<std::size_t> cuts;  ///< lines that cut

  void move(const char* code, const Pose& pose) {
    const Joints j = joints_for(pose);
    std::array<char, 160> line;
    std::snprintf(line.data(), line.size(), "%s X%.4f Y%.4f Z%.4f A%.4f C%.4f F1000", code, j.x, j.y, j.z,
                  j.a, j.c);
    std::string text = line.data();
    if (code[1] == '0') text.resize(text.size() - 6);
    lines.push_back(text);
  }
  /// Rows along x over the plate; the ball (or what tool there is) touches its top.
  Shop() {
    const auto axis = [](double x, double y) { return normalized({0.2 + 0.004 * x, -0.5 + 0.003 * y, 1.0}); };
    for (double y = -3.0; y < 3.01; y += 0.4) {
      const auto at = [&](double x, double up) {
        const Vec3 u = axis(x, y);
        // The ball's centre stands its radius over the plane, whatever the axis.
        return Pose{Point<Part>{x, y, kRadius} + u * (up - kRadius), u};
      };
      move("G0", at(-6, 10));
      move("G1", at(-6, 0));
      for (double x = -5.5; x < 6.01; x += 0.5) cuts.push_back(lines.size()), move("G1", at(x, 0));
      move("G0", at(6, 10));
    }
  }
  struct Outcome {
    Removal removal;
    RemovalVerdict verdict;
  };
  Outcome run(double cell, int threads = 2, const std::string& stock_text = "offset:0.5") {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    std::istringstream in(text), head(text);
    const auto program = read_program(in, "p.nc", 'A', 'C');
    EXPECT_TRUE(program) << program.error().message;
    const auto path = execute_program(*program, "p.nc", job.machine.model, job.setup);
    EXPECT_TRUE(path) << path.error().message;
    const auto shape = parse_stock(stock_text);
    auto stock = make_stock(*shape, part, job, cell, threads);
    EXPECT_TRUE(stock) << stock.error().message;
    Probes probes(part.mesh, cell, probe_reach(job));
    auto cut = remove_material(job, *path, *stock, probes, {job.plan.tolerance, threads}, {});
    EXPECT_TRUE(cut);
    const RemovalContext context{job, part, *shape, "p.nc", read_program_header(head)};
    const RemovalVerdict verdict = judge(*cut, context);
    json = to_json(context, *cut, verdict);
    return {*cut, verdict};
  }
  std::string json;

  /// Lines count from 1.
  static std::uint32_t number(std::size_t index) { return static_cast<std::uint32_t>(index + 1); }
};

const Trouble* first_of(const Removal& removal, TroubleKind kind) {
  for (const Trouble& t : removal.troubles)
    if (t.kind == kind) return &t;
  return nullptr;
}

/// Moves a word of a line.
void shift(std::string& line, char letter, double by) {
  const std::size_t at = line.find(letter);
  std::size_t used = 0;
  const double value = std::stod(line.substr(at + 1), &used);
  line = line.substr(0, at + 1) + std::to_string(value + by) + line.substr(at + 1 + used);
}

TEST(Removal, CleanProgramPasses) {
  for (const double cell : {0.5, 0.1}) {
    Shop shop;
    const auto [removal, verdict] = shop.run(cell);
    EXPECT_TRUE(verdict.passed()) << verdict.failures[0];
    EXPECT_TRUE(removal.troubles.empty());
    EXPECT_LE(verdict.gouge, 0.005);
    EXPECT_GT(removal.touched, 0u);
    // Between rows 0.4 apart a ball of radius 2 leaves ridges of 0.01 mm.
    EXPECT_NEAR(removal.excess[3], 0.0025, 0.004);
    EXPECT_GT(removal.excess[1], -0.005);
    EXPECT_LT(removal.air_seconds, 0.15 * removal.feed_seconds);
  }
}

TEST(Removal, SameForAnyNumberOfThreads) {
  Shop shop;
  shop.run(0.25, 1);
  const std::string one = shop.json;
  shop.run(0.25, 5);
  EXPECT_EQ(one, shop.json);
}

TEST(Removal, GougeIsFoundAtACoarseResolution) {
  for (const double cell : {1.0, 0.1}) {
    Shop shop;
    const std::size_t bad = shop.cuts[100];
    shift(shop.lines[bad], 'Z', -0.02);
    const auto [removal, verdict] = shop.run(cell);
    EXPECT_FALSE(verdict.passed());
    const Trouble* gouge = first_of(removal, TroubleKind::kGouge);
    ASSERT_NE(gouge, nullptr);
    EXPECT_NEAR(gouge->depth, 0.02, 0.002);
    EXPECT_NEAR(gouge->line, Shop::number(bad), 1);
    EXPECT_TRUE(gouge->facet == 1002 || gouge->facet == 1003);  // of the top
    EXPECT_NEAR(verdict.gouge, gouge->depth, 1e-12);
  }
}

TEST(Removal, DeletedBlockIsFound) {
  Shop shop;
  // Behind the plate stands a wall that the tool is led over at the end.
  shop.part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-8, 6, -6}, Vec3{8, 8, 4}}}));
  const Vec3 up = normalized({0.2, -0.5, 1.0});
  shop.move("G0", {Point<Part>{6, 20, 0} + up * 10.0, up});
  shop.lines.insert(shop.lines.begin(),
                    "(TILTFEED blocks " + std::to_string(shop.lines.size() - 1) + " time 1 s)");
  EXPECT_TRUE(shop.run(0.5).verdict.passed());
  // Without the last retract the tool runs into the wall; the header's count tells any deleted block.
  shop.lines.erase(shop.lines.end() - 2);
  const auto [removal, verdict] = shop.run(0.5);
  ASSERT_FALSE(verdict.failures.empty());
  EXPECT_NE(verdict.failures.back().find("header states"), std::string::npos);
  const Trouble* hit = first_of(removal, TroubleKind::kRapidPart);
  ASSERT_NE(hit, nullptr);
  EXPECT_EQ(hit->line, shop.lines.size());
}

TEST(Removal, WrongSignOfTheTiltIsFound) {
  Shop shop;
  const std::size_t bad = shop.cuts[200];
  const std::size_t at = shop.lines[bad].find('A') + 1;
  shop.lines[bad].insert(at, "-");
  const auto [removal, verdict] = shop.run(0.5);
  EXPECT_FALSE(verdict.passed());
  ASSERT_FALSE(removal.troubles.empty());
  bool located = false;
  for (const Trouble& t : removal.troubles)
    located |= t.line + 1 >= Shop::number(bad) && t.line <= Shop::number(bad) + 1;
  EXPECT_TRUE(located);
}

TEST(Removal, WrongToolLengthIsFound) {
  for (const double by : {0.5, -0.5}) {
    Shop shop;
    // The machine does not know: it moves its head, and the tool ends elsewhere.
    shop.job.machine.model.pivot_to_gauge.z += by;
    for (std::string& line : shop.lines)
      if (line.find('Z') != std::string::npos) shift(line, 'Z', -by);
    const auto [removal, verdict] = shop.run(0.5);
    EXPECT_FALSE(verdict.passed()) << by;
  }
}

TEST(Removal, RapidThroughThePartIsFound) {
  Shop shop;
  const std::size_t bad = shop.cuts[50];
  shift(shop.lines[bad], 'Z', -3.0);
  shop.lines[bad].replace(0, 2, "G0");
  const auto [removal, verdict] = shop.run(0.5);
  EXPECT_FALSE(verdict.passed());
  const Trouble* hit = first_of(removal, TroubleKind::kRapidPart);
  ASSERT_NE(hit, nullptr);
  EXPECT_EQ(hit->line, Shop::number(bad));
  EXPECT_GT(hit->depth, 1.0);
}

TEST(Removal, HolderHitIsFound) {
  Shop shop;
  shop.job.plan.cutter.shank_length = 15.0;
  shop.job.plan.cutter.cutting_length = 8.0;
  shop.job.plan.cutter.holder = {{20.0, 24.0, 20.0}};
  EXPECT_TRUE(shop.run(0.5).verdict.passed());
  // A post of stock beside the plate, as high as the holder is low.
  shop.part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-8, -14, -6}, Vec3{8, -11, 16}}}));
  const auto [removal, verdict] = shop.run(0.5);
  EXPECT_FALSE(verdict.passed());
  const Trouble* in_part = first_of(removal, TroubleKind::kGouge);
  ASSERT_NE(in_part, nullptr);
  EXPECT_EQ(in_part->tool, ToolPart::kHolder);
  const Trouble* in_stock = first_of(removal, TroubleKind::kStockHit);
  ASSERT_NE(in_stock, nullptr);
  EXPECT_EQ(in_stock->tool, ToolPart::kHolder);
}

// --- Bad input -------------------------------------------------------------------------------------------

TEST(RemovalInput, ProgramOfAnotherMachineOrTool) {
  const Job job = make_job();
  const auto check = [&](const std::string& text) {
    std::istringstream in(text);
    return check_header(read_program_header(in), job, "p.nc");
  };
  EXPECT_TRUE(check("(TILTFEED part plate D4 L100)\n(TILTFEED machine test)\nG0 X1\n"));
  EXPECT_TRUE(check("G0 X1\n"));
  for (const auto& [text, word] : {std::pair("(TILTFEED machine other)\n", "machine other"),
                                   std::pair("(TILTFEED part plate D6 L100)\n", "diameter 6"),
                                   std::pair("(TILTFEED part plate D4 L90)\n", "length 90"),
                                   std::pair("(TILTFEED part two words D4 L100)\n", "part two words")}) {
    const auto result = check(text);
    ASSERT_FALSE(result) << text;
    EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
  }
}

TEST(RemovalInput, BeyondTheTravel) {
  const Job job = make_job();
  std::istringstream in("G21 G90\nG0 X1 Y1 Z1 A0 C0\nG0 X501\n");
  const auto program = read_program(in, "p.nc", 'A', 'C');
  ASSERT_TRUE(program);
  const auto path = execute_program(*program, "p.nc", job.machine.model, job.setup);
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().code, Code::kLimit);
  EXPECT_NE(path.error().message.find("line 3: X 501"), std::string::npos) << path.error().message;
}

TEST(RemovalInput, StockTexts) {
  EXPECT_EQ(parse_stock("offset:2")->margin, 2.0);
  EXPECT_EQ(parse_stock("box")->kind, StockKind::kBox);
  EXPECT_EQ(parse_stock("cylinder:1.5")->margin, 1.5);
  for (const char* bad : {"offset", "offset:", "offset:-1", "box:x", "cylinder:1mm", "absent.stl", ""})
    EXPECT_EQ(parse_stock(bad).error().code, Code::kUsage) << bad;
}

TEST(RemovalInput, StockThatDoesNotHoldThePart) {
  const Job job = make_job();
  const CheckedMesh part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}}));
  const std::string path = BINARY_DIR "/removal_stock.stl";
  const auto write = [&](const Mesh& mesh) {
    std::vector<std::array<Point<Part>, 3>> facets;
    for (const auto& f : mesh.facets)
      facets.push_back({mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]});
    ASSERT_TRUE(write_stl(path, facets));
  };
  write(box_mesh({{Vec3{-9, -5, -7}, Vec3{9, 5, 1}}}));
  EXPECT_TRUE(make_stock(*parse_stock(path), part, job, 0.5, 2));
  write(box_mesh({{Vec3{-9, -5, -7}, Vec3{9, 3, 1}}}));  // a side is short
  const auto small = make_stock(*parse_stock(path), part, job, 0.5, 2);
  ASSERT_FALSE(small);
  EXPECT_EQ(small.error().code, Code::kInput);
  EXPECT_NE(small.error().message.find("does not hold the part"), std::string::npos);
  // Its box is large enough, a step in it is not.
  write(box_mesh({{Vec3{-9, -5, -7}, Vec3{0.01, 5, 1}}, {Vec3{0.02, -5, -7}, Vec3{9, 5, -1}}}));
  EXPECT_FALSE(make_stock(*parse_stock(path), part, job, 0.5, 2));
}

TEST(RemovalInput, MoreMemoryThanThereIs) {
  const Job job = make_job();
  const CheckedMesh part = checked(box_mesh({{Vec3{-400, -400, -400}, Vec3{400, 400, 0}}}));
  const auto stock = make_stock(*parse_stock("box"), part, job, 0.002, 2);
  ASSERT_FALSE(stock);
  EXPECT_EQ(stock.error().code, Code::kLimit);
  EXPECT_NE(stock.error().message.find("--resolution"), std::string::npos);
}

TEST(RemovalInput, OpenPart) {
  const Job job = make_job();
  CheckedMesh part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}}));
  part.sides = Sides::kBoth;
  EXPECT_EQ(make_stock(*parse_stock("offset:1"), part, job, 0.5, 2).error().code, Code::kMesh);
  EXPECT_TRUE(make_stock(*parse_stock("box:1"), part, job, 0.5, 2));
}

TEST(RemovalInput, Cancelled) {
  Shop shop;
  std::istringstream in(shop.lines[1] + "\n" + shop.lines[2] + "\n");
  const auto program = read_program(in, "p.nc", 'A', 'C');
  const auto path = execute_program(*program, "p.nc", shop.job.machine.model, shop.job.setup);
  ASSERT_TRUE(path);
  auto stock = make_stock(*parse_stock("box"), shop.part, shop.job, 0.5, 1);
  Probes probes(shop.part.mesh, 0.5, 0.5);
  const auto cut =
      remove_material(shop.job, *path, *stock, probes, {}, [](const char*, double) { return false; });
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().code, Code::kCancelled);
}

TEST(RemovalPage, HoldsEverythingAndFetchesNothing) {
  Shop shop;
  shift(shop.lines[shop.cuts[100]], 'Z', -0.2);
  const auto shape = parse_stock("offset:0.5");
  std::string text;
  for (const std::string& line : shop.lines) text += line + "\n";
  const std::string source = BINARY_DIR "/removal_program.nc", folder = BINARY_DIR "/removal_report";
  std::ofstream(source) << text;
  std::istringstream in(text);
  const auto path =
      execute_program(*read_program(in, "p.nc", 'A', 'C'), "p.nc", shop.job.machine.model, shop.job.setup);
  auto stock = make_stock(*shape, shop.part, shop.job, 0.5, 2);
  Probes probes(shop.part.mesh, 0.5, 0.5);
  const auto cut = remove_material(shop.job, *path, *stock, probes, {}, {});
  const RemovalContext context{shop.job, shop.part, *shape, source, {}};
  const RemovalVerdict verdict = judge(*cut, context);
  ASSERT_TRUE(write_removal_report(folder, context, *path, probes, *cut, verdict));
  std::ifstream page(folder + "/index.html");
  const std::string html{std::istreambuf_iterator<char>(page), {}};
  for (const char* part :
       {"FAILED", "id='trouble-1'", "href='#trouble-1'", "data:image/png;base64,iVBOR", "<mark>", "</html>"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  for (const char* part : {"http", "<script", "<link"}) EXPECT_EQ(html.find(part), std::string::npos) << part;
  const std::size_t marked = html.find("<mark>") + 6;
  EXPECT_EQ(html.substr(marked, html.find("</mark>") - marked), shop.lines[cut->troubles[0].line - 1]);
  for (const char* name : {"deviation.png", "path.png", "report.json"})
    EXPECT_GT(std::ifstream(folder + "/" + name, std::ios::ate).tellg(), 500) << name;
  EXPECT_FALSE(write_removal_report("/dev/null/x", context, *path, probes, *cut, verdict));
}

}  // namespace
}  // namespace tiltfeed::sim
