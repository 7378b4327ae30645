// Job files: every option of the cutter and of the path, read and described.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "config/job.h"
#include "config/polygon.h"
#include "tests/texts/bad_text.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

Job with_options(const std::string& from = "", const std::string& to = "") {
  const Result<Job> job = parse_job(from.empty() ? kOptionsJob : replaced(kOptionsJob, from, to), kJobPath);
  EXPECT_TRUE(job.has_value()) << job.error().message;
  return job.value_or(Job{});
}

TEST(JobOptions, ReadsEveryOptionOfTheCutter) {
  const Cutter cutter = with_options().plan.cutter;
  EXPECT_EQ(cutter.type, CutterType::kBullNose);
  EXPECT_EQ(cutter.diameter, 10.0);
  EXPECT_EQ(cutter.corner_radius, 2.0);
  EXPECT_EQ(cutter.cutting_length, 20.0);
  EXPECT_EQ(cutter.shank_diameter, 8.0);
  EXPECT_EQ(cutter.shank_length, 40.0);
  ASSERT_EQ(cutter.holder.size(), 2u);
  EXPECT_EQ(cutter.holder[0].lower_diameter, 20.0);
  EXPECT_EQ(cutter.holder[0].upper_diameter, 20.0);
  EXPECT_EQ(cutter.holder[0].length, 30.0);
  EXPECT_EQ(cutter.holder[1].lower_diameter, 30.0);
  EXPECT_EQ(cutter.holder[1].upper_diameter, 50.0);
  EXPECT_EQ(cutter.holder[1].length, 40.0);

  const std::string end = "type: bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2";
  EXPECT_EQ(with_options(end, "type: flat\n  diameter_mm: 10").plan.cutter.nose_radius(), 0.0);
  // A ball with a cone: its rounded end is lower than its radius, by that times the sine of the half-angle.
  const Cutter taper = with_options(end, "type: taper_ball\n  diameter_mm: 40\n  taper_deg: 30").plan.cutter;
  EXPECT_EQ(taper.type, CutterType::kTaperBall);
  EXPECT_NEAR(taper.taper.degrees(), 30.0, 1e-12);
  const std::string low =
      "type: taper_ball\n  diameter_mm: 40\n  taper_deg: 30\n  length_mm: 100\n"
      "  cutting_length_mm: 10.0001";
  const std::string lengths = end + "\n  length_mm: 100\n  cutting_length_mm: 20";
  EXPECT_EQ(with_options(lengths, low).plan.cutter.cutting_length, 10.0001);
  EXPECT_FALSE(parse_job(replaced(kOptionsJob, lengths, replaced(low, "10.0001", "9.9999")), kJobPath));
}

TEST(JobOptions, ReadsEveryOptionOfThePattern) {
  const Pattern pattern = with_options().plan.pattern;
  EXPECT_EQ(pattern.kind, PatternKind::kSplit);
  EXPECT_EQ(pattern.along, Along::kY);
  EXPECT_NEAR(pattern.angle.degrees(), 30.0, 1e-12);
  EXPECT_EQ(pattern.direction, Direction::kOneWay);
  EXPECT_EQ(pattern.measure, StepMeasure::kScallop);
  EXPECT_EQ(pattern.side_step, 0.5);
  EXPECT_EQ(pattern.scallop, 0.004);
  EXPECT_EQ(pattern.step_down, 0.7);
  EXPECT_FALSE(pattern.climb);
  EXPECT_NEAR(pattern.split_slope.degrees(), 60.0, 1e-12);
  EXPECT_EQ(with_options("  side_step_mm: 0.5\n", "").plan.pattern.side_step, 0.0);  // no limit
  const std::string by_height = "measure: scallop\n  side_step_mm: 0.5\n  scallop_mm: 0.004";
  const Pattern surface = with_options(by_height, "measure: surface\n  side_step_mm: 0.5").plan.pattern;
  EXPECT_EQ(surface.measure, StepMeasure::kSurface);
  EXPECT_EQ(surface.scallop, 0.0);
}

TEST(JobOptions, ReadsRidge) {
  const auto ridge = [](const std::string& keys) {
    return parse_job(replaced(kGoodJob, "side_step_mm: 0.5", "side_step_mm: 0.5, measure: ridge" + keys),
                     kJobPath);
  };
  const auto plain = ridge(""), limited = ridge(", scallop_mm: 0.02");
  ASSERT_TRUE(plain && limited);
  EXPECT_EQ(plain->plan.pattern.measure, StepMeasure::kRidge);
  EXPECT_EQ(plain->plan.pattern.side_step, 0.5);
  EXPECT_EQ(plain->plan.pattern.scallop, 0.0);
  EXPECT_EQ(limited->plan.pattern.scallop, 0.02);
  EXPECT_EQ(plain->plan.links.join_distance, 2.0);  // ends of rows twice as far apart
  EXPECT_FALSE(ridge(", scallop_mm: 200"));
}

TEST(JobOptions, ReadsPencil) {
  const auto pencil = [](const std::string& keys) {
    return parse_job(replaced(kGoodJob, "along: y, direction: one_way, side_step_mm: 0.5", keys), kJobPath);
  };
  const auto plain = pencil("kind: pencil");
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->plan.pattern.kind, PatternKind::kPencil);
  EXPECT_NEAR(plain->plan.pattern.crease_angle.degrees(), 10.0, 1e-12);
  const auto wide = pencil("kind: pencil, crease_angle_deg: 25");
  ASSERT_TRUE(wide) << wide.error().message;
  EXPECT_NEAR(wide->plan.pattern.crease_angle.degrees(), 25.0, 1e-12);
  EXPECT_NE(describe(*wide).find("\npattern.crease_angle_deg: 25\n"), std::string::npos);
  EXPECT_FALSE(pencil("kind: pencil, crease_angle_deg: 0.5"));
  EXPECT_FALSE(pencil("kind: pencil, side_step_mm: 0.5"));
  EXPECT_FALSE(pencil("crease_angle_deg: 20, side_step_mm: 0.5"));
}

TEST(JobOptions, ReadsFacesThatAloneAreMachined) {
  const auto with = [](const std::string& containment) {
    return parse_job(kGoodJob + "containment: {" + containment + "}\n", kJobPath);
  };
  const auto named = with("faces: [\"#ff0000\", seat], beyond_faces_mm: 0.7");
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(named->only_faces, (std::vector<std::string>{"#ff0000", "seat"}));
  EXPECT_EQ(named->beyond_faces, 0.7);
  EXPECT_NE(describe(*named).find("containment.faces[2]: seat\ncontainment.beyond_faces_mm: 0.7\n"),
            std::string::npos);
  const auto step = with("faces: [seat]");
  ASSERT_TRUE(step) << step.error().message;
  EXPECT_EQ(step->beyond_faces, 0.5);  // the side step
  for (const char* wrong : {"beyond_faces_mm: 1", "faces: []", "faces: [seat], beyond_faces_mm: -1"})
    EXPECT_FALSE(with(wrong)) << wrong;
}

TEST(JobOptions, ReadsTheBlank) {
  const auto with = [](const std::string& blank) {
    return parse_job(kGoodJob + "blank: {" + blank + "}\n", kJobPath);
  };
  EXPECT_FALSE(with_options().blank);
  const auto box = with("shape: box"), bar = with("shape: cylinder, margin_mm: 2.5"),
             file = with("shape: file, file: raw.stl, unit: inch");
  ASSERT_TRUE(box && bar && file);
  EXPECT_EQ(box->blank->shape, BlankShape::kBox);
  EXPECT_EQ(box->blank->margin, 0.0);
  EXPECT_EQ(bar->blank->shape, BlankShape::kCylinder);
  EXPECT_EQ(bar->blank->margin, 2.5);
  EXPECT_EQ(file->blank->path, kJobFolder + "raw.stl");
  EXPECT_EQ(file->blank->unit_mm, 25.4);
  EXPECT_NE(describe(*bar).find("blank.shape: cylinder\nblank.margin_mm: 2.5\n"), std::string::npos);
  for (const char* wrong : {"margin_mm: 1", "shape: ball", "shape: file", "shape: box, file: raw.stl",
                            "shape: file, file: raw.stl, margin_mm: 1", "shape: box, margin_mm: -1"})
    EXPECT_FALSE(with(wrong)) << wrong;
}

TEST(JobOptions, ReadsContainmentInTheModesOwnCoordinates) {
  const Containment point = with_options().plan.containment;
  EXPECT_EQ(point.first.low, -kPi);  // to the last digit: the seam belongs to it
  EXPECT_EQ(point.first.high, kPi / 2);
  EXPECT_EQ(point.second.low, -kPi / 4);
  EXPECT_EQ(point.second.high, kPi / 2);
  EXPECT_EQ(point.height.low, 5.0);
  EXPECT_EQ(point.height.high, 80.0);
  ASSERT_EQ(point.boundary.size(), 3u);
  EXPECT_EQ(point.boundary[1], (std::array<double, 2>{kPi / 2, 0.0}));
  EXPECT_EQ(point.boundary[2], (std::array<double, 2>{0.0, kPi / 4}));

  const auto in_mode = [](const std::string& axis, const std::string& limits) {
    const std::string text = replaced(kOptionsJob, "axis: {mode: point, sense: outward}", axis);
    const std::size_t from = text.find("  theta_deg"), to = text.find("  boundary");
    const Result<Job> job = parse_job(text.substr(0, from) + limits + text.substr(to), kJobPath);
    EXPECT_TRUE(job.has_value()) << job.error().message;
    return job.value_or(Job{}).plan.containment;
  };
  const Containment line = in_mode("axis: {mode: line, sense: inward}",
                                   "  x_mm: [-200, 300]\n  theta_deg: [-180, 180]\n  rho_mm: [1, 2]\n");
  EXPECT_EQ(line.first.low, -200.0);
  EXPECT_EQ(line.first.high, 300.0);
  EXPECT_EQ(line.second.high, kPi);
  EXPECT_EQ(line.height.high, 2.0);
  EXPECT_EQ(line.boundary[1], (std::array<double, 2>{90.0, 0.0}));
  EXPECT_EQ(line.boundary[2], (std::array<double, 2>{0.0, kPi / 4}));
  const Containment fixed = in_mode("axis: {mode: fixed}", "  y_mm: [-7, -6]\n  z_mm: [-50, 8]\n");
  EXPECT_FALSE(fixed.first.bounded());
  EXPECT_EQ(fixed.second.low, -7.0);
  EXPECT_EQ(fixed.height.low, -50.0);
  EXPECT_EQ(fixed.boundary[2], (std::array<double, 2>{0.0, 45.0}));
  const Containment circle =
      in_mode("axis: {mode: circle, sense: outward, circle_radius_mm: 9}", "  phi_deg: [-180, -90]\n");
  EXPECT_EQ(circle.second.low, -kPi);
  EXPECT_EQ(circle.second.high, -kPi / 2);
}

TEST(JobOptions, ReadsStockPointsGuardsAndLinks) {
  const PlanOptions plan = with_options().plan;
  EXPECT_EQ(plan.radial_stock, 0.1);
  EXPECT_EQ(plan.axial_stock, 0.2);
  EXPECT_EQ(plan.max_point_distance, 3.0);
  EXPECT_NEAR(plan.max_angle_step.degrees(), 5.0, 1e-12);
  EXPECT_EQ(plan.smoothing, 0.6);
  EXPECT_EQ(with_options().axis_tolerance, Angle{});
  const std::string no_stock = replaced(kOptionsJob, "stock: {radial_mm: 0.1, axial_mm: 0.2}\n", "");
  const auto leaning =
      parse_job(replaced(replaced(no_stock, "type: bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2",
                                  "type: ball\n  diameter_mm: 10"),
                         "smoothing_mm: 0.6", "axis_tolerance_deg: 2"),
                kJobPath);
  ASSERT_TRUE(leaning) << leaning.error().message;
  EXPECT_EQ(leaning->axis_tolerance, Angle::from_degrees(2.0));
  EXPECT_EQ(leaning->calm, Angle{});
  const auto calm =
      parse_job(replaced(replaced(no_stock, "type: bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2",
                                  "type: ball\n  diameter_mm: 10"),
                         "smoothing_mm: 0.6", "calm_deg: 3"),
                kJobPath);
  ASSERT_TRUE(calm) << calm.error().message;
  EXPECT_EQ(calm->calm, Angle::from_degrees(3.0));
  EXPECT_EQ(plan.links.rounds, 0u);
  EXPECT_EQ(with_options("lead_radius_mm: 1.5", "rounds: 40").plan.links.rounds, 40u);
  EXPECT_EQ(plan.shank.clearance, 0.5);
  EXPECT_EQ(plan.shank.reaction, Reaction::kRetract);
  EXPECT_EQ(plan.holder.clearance, 2.0);
  EXPECT_EQ(plan.holder.reaction, Reaction::kReport);
  EXPECT_EQ(plan.links.join_distance, 4.0);
  EXPECT_EQ(plan.links.lead_radius, 1.5);
}

TEST(JobOptions, OptionsThatAreLeftOutStayThePlannersOwn) {
  const Result<Job> job = parse_job(kGoodJob, kJobPath);
  ASSERT_TRUE(job.has_value()) << job.error().message;
  const PlanOptions plan = job->plan, planner;
  EXPECT_EQ(plan.cutter.type, CutterType::kBall);
  EXPECT_EQ(plan.cutter.cutting_length, 0.0);
  EXPECT_EQ(plan.cutter.shank_diameter, 0.0);
  EXPECT_TRUE(plan.cutter.holder.empty());
  EXPECT_EQ(plan.pattern.kind, planner.pattern.kind);
  EXPECT_EQ(plan.pattern.measure, planner.pattern.measure);
  EXPECT_EQ(plan.pattern.angle, planner.pattern.angle);
  EXPECT_EQ(plan.pattern.climb, planner.pattern.climb);
  EXPECT_EQ(plan.pattern.split_slope, planner.pattern.split_slope);
  EXPECT_FALSE(plan.containment.first.bounded() || plan.containment.second.bounded() ||
               plan.containment.height.bounded());
  EXPECT_TRUE(plan.containment.boundary.empty());
  EXPECT_EQ(plan.radial_stock, planner.radial_stock);
  EXPECT_EQ(plan.axial_stock, planner.axial_stock);
  EXPECT_EQ(plan.max_point_distance, planner.max_point_distance);
  EXPECT_EQ(plan.max_angle_step, planner.max_angle_step);
  EXPECT_EQ(plan.smoothing, planner.smoothing);
  EXPECT_EQ(plan.shank.reaction, planner.shank.reaction);
  EXPECT_EQ(plan.shank.clearance, planner.shank.clearance);
  EXPECT_EQ(plan.links.join_distance, 2.0 * plan.pattern.side_step);  // neighbours, on slopes too
  const auto by_height =
      parse_job(replaced(kGoodJob, "side_step_mm: 0.5", "measure: scallop, scallop_mm: 0.005"), kJobPath);
  ASSERT_TRUE(by_height) << by_height.error().message;
  EXPECT_NEAR(by_height->plan.links.join_distance, 4.0 * std::sqrt(2.0 * 3.0 * 0.005 - 0.005 * 0.005), 1e-9);
  EXPECT_EQ(plan.links.lead_radius, planner.links.lead_radius);
}

bool has_line(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line) != std::string::npos;
}

TEST(JobOptions, DescribesEveryOption) {
  const std::string text = describe(with_options());
  for (const char* line : {"cutter.type: bull_nose\n",
                           "cutter.corner_radius_mm: 2\n",
                           "cutter.cutting_length_mm: 20\n",
                           "cutter.shank_diameter_mm: 8\n",
                           "cutter.holder[1].diameter_mm: 20\n",
                           "cutter.holder[1].upper_diameter_mm: 20\n",
                           "cutter.holder[1].length_mm: 30\n",
                           "cutter.holder[2].diameter_mm: 30\n",
                           "cutter.holder[2].upper_diameter_mm: 50\n",
                           "cutter.holder[2].length_mm: 40\n",
                           "cutter.holder_top_mm: 110\n",
                           "pattern.kind: split\n",
                           "pattern.along: y\n",
                           "pattern.angle_deg: 30\n",
                           "pattern.direction: one_way\n",
                           "pattern.measure: scallop\n",
                           "pattern.side_step_mm: 0.5\n",
                           "pattern.scallop_mm: 0.004\n",
                           "pattern.step_down_mm: 0.7\n",
                           "pattern.milling: conventional\n",
                           "pattern.split_slope_deg: 60\n",
                           "containment.theta_deg: [-180, 90]\n",
                           "containment.phi_deg: [-45, 90]\n",
                           "containment.rho_mm: [5, 80]\n",
                           "containment.boundary[1]: [0, 0]\n",
                           "containment.boundary[2]: [90, 0]\n",
                           "containment.boundary[3]: [0, 45]\n",
                           "stock.radial_mm: 0.1\n",
                           "stock.axial_mm: 0.2\n",
                           "points.max_distance_mm: 3\n",
                           "points.max_angle_deg: 5\n",
                           "points.smoothing_mm: 0.6\n",
                           "points.axis_tolerance_deg: 0\n",
                           "points.calm_deg: 0\n",
                           "guards.shank.clearance_mm: 0.5\n",
                           "guards.shank.reaction: retract\n",
                           "guards.holder.clearance_mm: 2\n",
                           "guards.holder.reaction: report\n",
                           "links.join_distance_mm: 4\n",
                           "links.lead_radius_mm: 1.5\n",
                           "links.rounds: 0\n"})
    EXPECT_TRUE(has_line(text, line)) << line << text;
  const std::string end = "type: bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2";
  EXPECT_TRUE(has_line(describe(with_options(end, "type: taper_ball\n  diameter_mm: 10\n  taper_deg: 7")),
                       "cutter.taper_deg: 7\n"));
  EXPECT_TRUE(
      has_line(describe(with_options("  side_step_mm: 0.5\n", "")), "pattern.side_step_mm: no limit\n"));
}

/// Points on a circle, joined in a random order: the only orders without crossing edges are round the circle.
TEST(Polygon, CornersOnACircleMustBeInOrder) {
  std::mt19937 dice(5);
  int simple = 0;
  for (int round = 0; round < 4000; ++round) {
    const std::size_t count = 3 + dice() % 4;
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[dice() % i]);
    std::vector<std::array<double, 2>> corners;
    bool forwards = true, backwards = true;
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = 0.3 + 2 * kPi * static_cast<double>(order[i]) / static_cast<double>(count);
      corners.push_back({5 + 3 * std::cos(angle), -2 + 0.01 * std::sin(angle)});
      const std::size_t next = order[(i + 1) % count];
      forwards = forwards && next == (order[i] + 1) % count;
      backwards = backwards && order[i] == (next + 1) % count;
    }
    simple += forwards || backwards;
    const auto fault = polygon_fault(corners);
    ASSERT_EQ(!fault.has_value(), forwards || backwards)
        << (fault ? fault->message : "") << testing::PrintToString(corners);
  }
  EXPECT_GT(simple, 1000);
  EXPECT_LT(simple, 3000);
}

}  // namespace
}  // namespace tiltfeed
