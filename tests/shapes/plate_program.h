#pragma once
// A job, a plate and a program that finishes it, for the tests of verification and of material removal.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "sim/removal/removal.h"
#include "sim/report/report.h"
#include "tests/shapes/box_mesh.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;

inline constexpr double kRadius = 2.0, kPivot = 150.0;

inline CheckedMesh checked(const Mesh& mesh) {
  CheckedMesh part;
  part.mesh = mesh;
  part.bounds = {mesh.vertices[0], mesh.vertices[0]};
  for (const Point<Part> p : mesh.vertices) part.bounds = grown(part.bounds, p);
  return part;
}

/// A block of stock, in lines along all three axes.
inline Stock stock_block(const Box& box, double cell) {
  Stock stock{{}, box, cell};
  for (int axis = 0; axis < 3; ++axis) {
    stock.bundles.emplace_back(axis, box, cell);
    for (int s = 0; s < Dexels::kStripes; ++s)
      stock.bundles.back().fill(s, box), stock.bundles.back().settle(s);
  }
  return stock;
}

inline Job make_job() {
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

/// (K3) with w = 0, v = (0, 0, -L), written out.
inline Joints joints_for(const Pose& p) {
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
  std::vector<Pose> poses;        ///< of the lines from the second on, as they were made

  void move(const char* code, const Pose& pose) {
    poses.push_back(pose);
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
  /// Gives every feed move the time in which the tip moves at 1000 mm/min, what is returned.
  double time_by_tip() {
    constexpr double kFeed = 1000.0;
    lines[0] = "G21 G90 G93";
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::size_t at = lines[i].find(" F");
      if (at == std::string::npos) continue;
      const double minutes = distance(poses[i - 2].tip, poses[i - 1].tip) / kFeed;
      lines[i] = lines[i].substr(0, at) + " F" + std::to_string(1.0 / minutes);
    }
    return kFeed;
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

inline const Trouble* first_of(const Removal& removal, TroubleKind kind) {
  for (const Trouble& t : removal.troubles)
    if (t.kind == kind) return &t;
  return nullptr;
}

/// Moves a word of a line.
inline void shift(std::string& line, char letter, double by) {
  const std::size_t at = line.find(letter);
  std::size_t used = 0;
  const double value = std::stod(line.substr(at + 1), &used);
  line = line.substr(0, at + 1) + std::to_string(value + by) + line.substr(at + 1 + used);
}

}  // namespace tiltfeed::sim
