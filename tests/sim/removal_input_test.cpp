// Material removal: bad input is refused before work starts; the report page.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "sim/motion/forward.h"
#include "sim/report/verify_command.h"
#include "sim/solid/distance.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

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

TEST(RemovalInput, ToolThatTheProgramMovesWith) {
  const auto check = [](int tool, const std::string& text) {
    Job job = make_job();
    job.path = "job.yaml", job.program.tool = tool;
    std::istringstream in("G21 G90 G94\n" + text);
    const auto program = read_program(in, "p.nc", 'A', 'C');
    EXPECT_TRUE(program) << text;
    const auto checked = check_tool(*program, job, "p.nc");
    return checked ? std::string() : checked.error().message;
  };
  struct Case {
    int tool;             ///< of the job
    const char* text;     ///< after the first line
    const char* refused;  ///< what is said; empty: nothing
  };
  for (const Case& c : std::vector<Case>{
           {0, "G0 X1\nG1 X2 F9\n", ""},
           {3, "G0 X1\nG1 X2 F9\n", ""},
           {3, "M6\nG1 X2 F9\n", ""},
           {3, "T3 M6\nG0 X1\nG1 X2 F9\n", ""},
           {3, "T3\nM6\nG1 X2 F9\n", ""},
           {3, "T3\nG1 X2 F9\n", ""},
           {3, "T3 M6\nT7\nG1 X2 F9\nM6\n", ""},        // chosen early, changed after the last move
           {3, "T3 M6\nG1 X2 F9\nT0 M6\nG0 X1\n", ""},  // put away, home
           {3, "T7\nG0 X1\nG1 X2 F9\n", "line 3 moves with tool T7"},
           {3, "T7 M6\nG0 X1\nT3 M6\nG1 X2 F9\n", "line 3 moves with tool T7"},
           {3, "N50 T3 M6\nN60 G1 X2 F9\nN70 T4\nN80 M6\nN90 G0 X1\n", "line 90 moves with tool T4"},
           {3, "T0 M6\nG0 X1\nG1 X2 F9\n", "line 4 moves with tool T0"},
           {3, "M6 T5\nG1 X2 F9\n", "has the cutter of tool 3 (program.tool)"},
           {0, "T5 M6\nG1 X2 F9\n", "state program.tool"}}) {
    const std::string said = check(c.tool, c.text);
    if (*c.refused == '\0')
      EXPECT_EQ(said, "") << c.text;
    else
      EXPECT_NE(said.find(c.refused), std::string::npos) << c.text << said;
  }
}

TEST(RemovalInput, TraceOfAnotherMachineOrTool) {
  const Job job = make_job();
  std::vector<TraceRow> trace(3);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const double lean = 0.3 * static_cast<double>(i);
    trace[i].block = i + 1;
    trace[i].pose = {{1.0 * static_cast<double>(i), 2, 3},
                     {0.6 * std::sin(lean), -0.8 * std::sin(lean), std::cos(lean)}};
    trace[i].command.target = joints_for(trace[i].pose);
  }
  trace[1].command.op = Op::kMCode, trace[1].pose.tip.x += 5.0;  // says nothing of the axes
  EXPECT_TRUE(check_trace(trace, job, "t.csv"));
  Job longer = job, moved = job, turned = job;
  longer.setup.tool_length += 0.05;
  moved.setup.part_zero.x += 0.05;
  turned.machine.model.rotary.sign = +1, turned.machine.model.rotary.zero = 30.0;
  for (const Job& other : {longer, moved, turned}) {
    const auto checked = check_trace(trace, other, "t.csv");
    ASSERT_FALSE(checked);
    EXPECT_NE(checked.error().message.find("t.csv: block "), std::string::npos) << checked.error().message;
    EXPECT_NE(checked.error().message.find("another machine"), std::string::npos);
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

/// An L and a box beside it, both leaning: edges that are convex and one that is not, a narrow gap.
CheckedMesh leaning_part() {
  const std::array<std::array<double, 2>, 6> outline{{{0, 0}, {20, 0}, {20, 6}, {7, 6}, {7, 15}, {0, 15}}};
  Mesh mesh = box_mesh({{Vec3{9.5, 8.5, 1}, Vec3{19, 14, 9}}});
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const double z : {0.0, 8.0})
    for (const auto& [x, y] : outline) mesh.vertices.push_back({x, y, z});
  for (const auto& [a, b, c] : {std::array<std::uint32_t, 3>{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.facets.push_back({base + a, base + c, base + b});
    mesh.facets.push_back({base + 6 + a, base + 6 + b, base + 6 + c});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t next = (i + 1) % 6;
    mesh.facets.push_back({base + i, base + next, base + 6 + next});
    mesh.facets.push_back({base + i, base + 6 + next, base + 6 + i});
  }
  mesh.source.assign(mesh.facets.size(), 0);
  const Rotation lean = rotation_about(normalized({1, 2, 0.5}), 0.4);
  for (Point<Part>& p : mesh.vertices) p = Point<Part>{} + lean * from_origin(p);
  return checked(mesh);
}

TEST(RemovalInput, OffsetStockIsWhatIsWithinItsMarginOfThePart) {
  const Job job = make_job();
  const CheckedMesh part = leaning_part();
  const PartDistance distance(part.mesh);
  constexpr double kMargin = 1.3, kCell = 0.7, kStep = 0.31;
  const auto stock = make_stock({StockKind::kOffset, kMargin, {}}, part, job, kCell, 2);
  ASSERT_TRUE(stock);
  const Vec3 low = from_origin(stock->box.min), high = from_origin(stock->box.max);
  for (const Dexels& bundle : stock->bundles) {
    // By the foot of the line.
    std::map<std::array<double, 3>, std::vector<std::array<double, 2>>> pieces;
    for (int stripe = 0; stripe < Dexels::kStripes; ++stripe)
      bundle.each(stripe, [&](Point<Part> foot, double from, double to) {
        pieces[{foot.x, foot.y, foot.z}].push_back({from, to});
      });
    const std::array<double, 3> least{low.x, low.y, low.z}, most{high.x, high.y, high.z};
    const int along = bundle.axis(), u = (along + 1) % 3, v = (along + 2) % 3;
    int inside = 0, wrong = 0;
    for (int i = 0; least[u] + (i + 0.5) * kCell < most[u]; ++i) {
      for (int j = 0; least[v] + (j + 0.5) * kCell < most[v]; ++j) {
        std::array<double, 3> p{};
        p[u] = least[u] + (i + 0.5) * kCell, p[v] = least[v] + (j + 0.5) * kCell;
        const auto& of_line = pieces[p];
        for (p[along] = least[along]; p[along] < most[along]; p[along] += kStep) {
          const Point<Part> at{p[0], p[1], p[2]};
          const double off = distance.nearest(at).value;
          if (std::abs(off - kMargin) < 1e-3) continue;
          const bool expected = off < kMargin || distance.winding_number(at) > 0.5;
          const bool is = std::any_of(of_line.begin(), of_line.end(), [&](const auto& piece) {
            return piece[0] < p[along] && p[along] < piece[1];
          });
          inside += is, wrong += is != expected;
        }
      }
    }
    EXPECT_EQ(wrong, 0) << along;
    EXPECT_GT(inside, 10000) << along;
  }
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
  EXPECT_EQ(verdict.unseen, "");
  Removal coarse = *cut;
  coarse.cell = 1.0;
  EXPECT_NE(judge(coarse, context).unseen.find("--resolution 0.25 sees it"), std::string::npos)
      << "lines that are further apart than the stock's skin is thick";
  ASSERT_TRUE(make_report_folder(folder));
  const Drawings drawings = draw_report(shop.job, shop.part, *path, probes.patches());
  const RemovalFindings findings{context, drawings, *cut, verdict, *path, probes, nullptr};
  ASSERT_TRUE(write_removal_report(folder, findings, 2));
  std::ifstream page(folder + "/index.html");
  const std::string html{std::istreambuf_iterator<char>(page), {}};
  for (const char* part :
       {"FAILED", "id='trouble-1'", "href='#trouble-1'", "data:image/png;base64,iVBOR", "<mark>", "</html>"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  for (const char* part : {"src='http", "href='http", "<link", "url(h"})
    EXPECT_EQ(html.substr(0, html.find("<script")).find(part), std::string::npos) << part;
  EXPECT_LT(html.find("default-src 'none'"), html.find("<style"));
  const std::size_t marked = html.find("<mark>") + 6;
  EXPECT_EQ(html.substr(marked, html.find("</mark>") - marked), shop.lines[cut->troubles[0].line - 1]);
  for (const char* name : {"deviation.png", "path.png", "report.json"})
    EXPECT_GT(std::ifstream(folder + "/" + name, std::ios::ate).tellg(), 500) << name;
  EXPECT_FALSE(write_removal_report("/dev/null/x", findings, 2));
  // The page alone: the same.
  ASSERT_TRUE(write_removal_report(folder + "/alone.html", findings, 2));
  std::ifstream alone(folder + "/alone.html");
  EXPECT_EQ((std::string{std::istreambuf_iterator<char>(alone), {}}), html);
  EXPECT_FALSE(make_report_folder("/dev/null/x"));
}

}  // namespace
}  // namespace tiltfeed::sim
