// What `suggest` proposes, against random placements: suggest_bench MACHINE.yaml DIAMETER RANDOM PART...,
// PART the name of a part by formula or FILE.stl[:UNIT_MM]. A table.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>

#include "config/machine_profile.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/suggest/mounting.h"
#include "pathgen/suggest/placements.h"
#include "pathgen/suggest/plain_faces.h"
#include "pathgen/suggest/suggest.h"
#include "pathgen/tool/contact_line.h"
#include "sim/parts/parts.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::pathgen;
using namespace tiltfeed::config;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Result<CheckedMesh> part_of(std::string name) {
  if (const auto triangles = sim::part_by_name(name)) {
    Stl stl;
    stl.facets = *triangles;
    return check_mesh(stl);
  }
  double unit = 1.0;
  if (const auto colon = name.rfind(':'); colon != name.npos)
    unit = std::atof(name.c_str() + colon + 1), name.resize(colon);
  const auto stl = read_stl(name, unit);
  if (!stl) return tl::unexpected(stl.error());
  return check_mesh(*stl);
}

const char* word(AxisMode mode) {
  constexpr const char* kWords[] = {"fixed", "point", "line", "circle", "free", "indexed"};
  return kWords[static_cast<int>(mode)];
}

struct Dice {
  std::mt19937 random{1};
  double even(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  Vec3 direction() {
    const double z = even(-1.0, 1.0), turn = even(-kPi, kPi), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return std::fprintf(stderr, "suggest_bench MACHINE.yaml DIAMETER RANDOM PART...\n"), 2;
  const auto machine = load_machine(argv[1]);
  if (!machine) return std::fprintf(stderr, "%s\n", machine.error().message.c_str()), 1;
  for (int i = 4; i < argc; ++i) {
    const auto part = part_of(argv[i]);
    if (!part) {
      std::printf("%-40s %s\n", argv[i], part.error().message.c_str());
      continue;
    }
    const double size = distance(part->bounds.min, part->bounds.max);
    SuggestOptions options;
    options.machine = &machine->model;
    double diameter = std::atof(argv[2]);
    if (diameter <= 0.0) diameter = size / 60.0;
    options.tool.cutter = {diameter, 120.0, std::min(60.0, 20.0 * diameter)};
    const double before = seconds();
    const std::clock_t clock = std::clock();
    const auto found = suggest(*part, options);
    const double wall = seconds() - before,
                 processor = static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
    if (!found) {
      std::printf("%-40s %s\n", argv[i], found.error().message.c_str());
      continue;
    }
    std::printf("%s: %zu facets, size %.4g, ball %.3g; %.2f s wall, %.2f s processor, %zu placements\n",
                argv[i], part->mesh.facets.size(), size, diameter, wall, processor, found->tried);
    for (const Feature& f : found->features)
      std::printf("  feature %-6s at %.5f %.5f %.5f axis %.6f %.6f %.6f radius %.5f share %.3f rms %.2g\n",
                  word(f.mode), f.centre.x, f.centre.y, f.centre.z, f.axis.x, f.axis.y, f.axis.z, f.radius,
                  f.share, f.rms);
    for (const Proposal& p : found->proposals) {
      const Vec3 a = axis_of(p.axis);
      std::printf(
          "  %-7s %-8s %-14s share %5.2f %% shaped %5.2f %% at %.4f %.4f %.4f axis %.4f %.4f %.4f radius "
          "%.4f fixture %.1f %.1f %.1f;",
          word(p.axis.mode), p.axis.sense == Sense::kOutward ? "outward" : "inward", p.source.c_str(),
          100.0 * p.share(), 100.0 * p.shaped, p.axis.origin.x, p.axis.origin.y, p.axis.origin.z, a.x, a.y,
          a.z, p.axis.circle_radius, p.fixture_deg.x, p.fixture_deg.y, p.fixture_deg.z);
      for (std::size_t k = 1; k < kReaches; ++k)
        if (p.reach.area[k] > 0.0)
          std::printf(" %s %.1f", word_of(static_cast<Reach>(k)),
                      100.0 * p.reach.share(static_cast<Reach>(k)));
      std::printf("\n");
    }
    const int count = std::atoi(argv[3]);
    if (count == 0) continue;
    const ReachScene scene(*part, options.tool);
    const ToolPiece piece = tool_pieces(options.tool).front();
    const auto places = scene.sample(2000);
    const Mounting mounting(&machine->model, part->bounds, options.tool.cutter.length);
    const Point<Part> middle = lerp(part->bounds.min, part->bounds.max, 0.5);
    const auto weights = weights_of(part->mesh, places, found->features, size);
    struct Shares {
      double all = 0.0, shaped = 0.0;
    };
    const auto asked = [&](const AxisFrame& frame, const Setup& setup, const std::vector<Vec3>& directions) {
      const MachineReach reach(machine->model, setup);
      ReachQuestion q;
      q.axis = frame, q.machine = &reach, q.directions = directions;
      const ReachMap map = scene.ask(q, places, Rays::kRim);
      double cut = 0.0, whole = 0.0;
      for (std::size_t k = 0; k < places.size(); ++k) {
        whole += weights[k];
        if (map.places[k] == Reach::kCut) cut += weights[k];
      }
      return Shares{map.share(Reach::kCut), cut / whole};
    };
    // Random placements, mounted as the proposals are.
    const auto mounted = [&](const AxisFrame& frame) {
      ReachQuestion q;
      q.axis = frame;
      const ReachMap map = scene.ask(q, places, Rays::kRim);
      const Deformation field(frame, 1.0);
      std::vector<CutPose> poses;
      for (std::size_t k = 0; k < places.size(); ++k) {
        if (map.places[k] != Reach::kCut) continue;
        const AxisLine line = contact_line(piece, field, places[k].place, places[k].normal);
        poses.push_back({{line.base - line.axis * (diameter / 2.0), line.axis}, places[k].area});
      }
      return poses.empty() ? Shares{}
                           : asked(frame, mounting.best(poses, axis_of(frame), std::nullopt).setup, {});
    };
    Dice dice;
    Shares most;
    for (int k = 0; k < count; ++k) {
      constexpr AxisMode kModes[] = {AxisMode::kPoint, AxisMode::kLine, AxisMode::kCircle, AxisMode::kFixed};
      const Point<Part> at = middle + dice.direction() * (size * dice.even(0.0, 1.0));
      const Shares s = mounted(frame_about(kModes[k % 4], k / 4 % 2 == 0 ? Sense::kOutward : Sense::kInward,
                                           at, dice.direction(), size * dice.even(0.02, 1.0)));
      most.all = std::max(most.all, s.all), most.shaped = std::max(most.shaped, s.shaped);
    }
    Shares first = asked(found->proposals[0].axis, found->proposals[0].setup, found->proposals[0].directions),
           field;
    for (const Proposal& p : found->proposals)
      if (p.axis.mode != AxisMode::kFree && p.axis.mode != AxisMode::kIndexed) {
        const Shares s = asked(p.axis, p.setup, {});
        field.all = std::max(field.all, s.all), field.shaped = std::max(field.shaped, s.shaped);
      }
    std::printf(
        "  RANDOM %d: best %.2f %% shaped %.2f %%; first proposal (%s) %.0f %% of it, shaped %.0f %%; best "
        "axis "
        "field %.0f %%, shaped %.0f %%\n",
        count, 100.0 * most.all, 100.0 * most.shaped, word(found->proposals[0].axis.mode),
        100.0 * first.all / most.all, 100.0 * first.shaped / most.shaped, 100.0 * field.all / most.all,
        100.0 * field.shaped / most.shaped);
    std::fflush(stdout);
  }
}
