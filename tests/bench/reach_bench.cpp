// How long the reach of a part takes to ask: reach_bench [tyre|pin|sphere|handle].

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/exact_reach.h"
#include "sim/parts/parts.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::pathgen;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

PlanOptions tyre_job() {
  PlanOptions o;
  o.name = "tyre";
  o.cutter = {2.0, 120.0, 40.0};
  o.axis = {AxisMode::kCircle, Sense::kInward, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 280.0};
  o.pattern.along = Along::kY, o.pattern.side_step = 0.2;
  o.links = {5.0, 1.0, 0.0, 0.0};
  o.cut_feed = Feed::from_mm_per_min(2000), o.plunge_feed = Feed::from_mm_per_min(600);
  return o;
}

}  // namespace

int main(int argc, char** argv) {
  const auto triangles = sim::part_by_name(argc > 1 ? argv[1] : "tyre");
  if (!triangles) return std::fprintf(stderr, "%s\n", triangles.error().message.c_str()), 2;
  Stl stl;
  stl.facets = *triangles;
  const auto part = check_mesh(stl);
  if (!part) return 1;
  const PlanOptions job = tyre_job();
  double at = seconds();
  const auto lap = [&] {
    const double before = at;
    return at = seconds(), at - before;
  };
  const ReachScene scene(*part, job);
  std::printf("%zu facets: scene %.3f s", part->mesh.facets.size(), lap());
  const auto facets = scene.facets();
  std::printf(", facets %.3f s\n", lap());
  for (const Rays rays : {Rays::kAxis, Rays::kRim}) {
    std::vector<double> times;
    const std::clock_t before = std::clock();
    ReachQuestion q;
    q.axis = job.axis;
    ReachMap map;
    for (int k = 0; k < 40; ++k) {
      q.axis.origin.z = 0.1 * (k % 7);
      lap();
      map = scene.ask(q, facets, rays);
      times.push_back(lap());
    }
    std::sort(times.begin(), times.end());
    std::printf("%s: median %.1f ms, worst %.1f ms, processor %.1f ms; cut %.2f %%\n",
                rays == Rays::kAxis ? "axis" : "rim ", 1e3 * times[times.size() / 2], 1e3 * times.back(),
                1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / 40.0,
                100.0 * map.share(Reach::kCut));
  }
  ReachQuestion q;
  q.axis = job.axis;
  lap();
  const auto exact = exact_reach(*part, job, scene, facets, q);
  if (!exact) return std::fprintf(stderr, "%s\n", exact.error().message.c_str()), 1;
  std::printf("exact %.3f s\n", lap());
  const ReachMap axis = scene.ask(q, facets, Rays::kAxis), rim = scene.ask(q, facets, Rays::kRim);
  for (std::size_t i = 0; i < kReaches; ++i) {
    const auto reach = static_cast<Reach>(i);
    std::printf("%-8s exact %6.2f %%, axis %6.2f %%, rim %6.2f %%\n", word_of(reach),
                100.0 * exact->share(reach), 100.0 * axis.share(reach), 100.0 * rim.share(reach));
  }
}
