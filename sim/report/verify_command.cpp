#include "sim/report/verify_command.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <future>
#include <iostream>
#include <optional>
#include <string_view>
#include <thread>

#include "config/job.h"
#include "config/job_inputs.h"
#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "sim/basics/workers.h"
#include "sim/control/program_frame.h"
#include "sim/control/slide_blocks.h"
#include "sim/gcode/canon.h"
#include "sim/removal/executed_path.h"
#include "sim/removal/removal.h"
#include "sim/removal/stock.h"
#include "sim/report/program_header.h"
#include "sim/report/report.h"
#include "sim/report/verify_progress.h"

namespace tiltfeed::sim {
namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2, kIncomplete = 3;
// A line of a program is hardly shorter: a header that states more blocks is wrong.
constexpr std::uint64_t kBytesPerBlock = 8;
// Axes that travel linearly instead of a tip that does may leave its way by this share of the tolerance.
constexpr double kTipShare = 0.1;
constexpr double kFinest = 1e-3, kCoarsest = 50.0;
// Without --resolution: a tenth of the cutter, and so many cells along the part's longest side at most.
constexpr double kCellsPerDiameter = 10.0, kCellsPerSide = 1500.0;

// Nothing is written before all of the report is made, so there is nothing to put in order: the process ends
// at once, whatever it is at. Only what a signal handler may call.
constexpr std::string_view kCancelled = "tiltfeed verify: verification was cancelled\n";
extern "C" void cancel_simulation(int) {
  constexpr std::string_view kClearLine = "\r\033[K";
  ssize_t sent = 0;
  if (isatty(STDERR_FILENO) == 1) sent = write(STDERR_FILENO, kClearLine.data(), kClearLine.size());
  if (sent >= 0) sent = write(STDERR_FILENO, kCancelled.data(), kCancelled.size());
  static_cast<void>(sent);
  _exit(kFailed);
}

int report(const Error& error) {
  std::cerr << "tiltfeed verify: " << error.message << "\n";
  return error.code == Code::kUsage ? kWrongUse : kFailed;
}

double default_cell(const config::Job& job, const pathgen::CheckedMesh& part) {
  const Vec3 size = part.bounds.max - part.bounds.min;
  const double cell = std::max(job.plan.cutter.diameter / kCellsPerDiameter,
                               std::max({size.x, size.y, size.z}) / kCellsPerSide);
  return std::ceil(cell * 100.0) / 100.0;
}

/// Why the stock is what nobody said that it is.
std::string stock_from(const RemovalOptions& options) {
  return options.stock_known
             ? ", taken from the job's approach_mm and pattern; --stock says another"
             : ", taken as the part is open: what touches it is not judged; --stock gives one";
}

/// The one file that says the moves.
struct Moves {
  Source kind;
  const std::string& name;
};
Moves moves_of(const VerifyOptions& o) {
  if (!o.program.empty()) return {Source::kProgram, o.program};
  if (!o.trace.empty()) return {Source::kTrace, o.trace};
  return {Source::kCanon, o.canon};
}

/// The blocks of a program in the dialect of the job's machine, X Y Z those of the slides.
Result<void> read_in_dialect(std::istream& in, const std::string& name, const config::Job& job,
                             const std::function<void(const Block&)>& take) {
  const config::Dialect dialect = job.machine.format.dialect;
  // With a tool number the text has the words of a tool change, which the simulated controller has not.
  if ((dialect == config::Dialect::kRs274 || dialect == config::Dialect::kGrbl) && job.program.tool == 0)
    return read_program(in, name, GcodeReader(job.machine.model), take);
  ControlReader reader(job.machine, job.setup);
  SlideBlocks slides(job.machine.model, job.setup, ToolSolid(job.plan.cutter).top(),
                     kTipShare * job.plan.tolerance);
  return read_control_program(in, name, reader, [&](const ControlBlock& one) { slides.take(one, take); });
}

/// Executes the program as it is read, which no memory for all of its blocks is needed for.
Result<ExecutedPath> read_and_execute(std::ifstream& in, const std::string& name, const config::Job& job,
                                      ProgramHeader& header) {
  header = read_program_header(in);
  if (auto fits = check_header(header, job, name); !fits) return tl::unexpected(fits.error());
  in.clear();
  in.seekg(0);
  if (auto sound = check_frame(in, name, job); !sound) return tl::unexpected(sound.error());
  in.clear();
  const auto size =
      static_cast<std::uint64_t>(std::max<std::streamoff>(0, in.seekg(0, std::ios::end).tellg()));
  in.seekg(0);
  const std::uint64_t expected = std::min(header.blocks.value_or(0), size / kBytesPerBlock);
  ProgramRun run(name, job.machine.model, job.setup, motion_options(job.machine), expected);
  Result<void> fits;
  const auto take = [&](const Block& block) {
    if (fits) fits = check_tool(block, job, name);
    if (fits) run.take(block);
  };
  const auto read = read_in_dialect(in, name, job, take);
  // What cannot be read comes before what does not fit, wherever it is.
  if (!read) return tl::unexpected(read.error());
  if (!fits) return tl::unexpected(fits.error());
  return run.finish();
}

/// Reads the moves.
Result<ExecutedPath> read_path(const VerifyOptions& options, const config::Job& job, ProgramHeader& header) {
  const auto [kind, name] = moves_of(options);
  const MachineModel& machine = job.machine.model;
  std::ifstream in(name, std::ios::binary);
  if (!in) return fail(Code::kIo, name + ": cannot be opened");
  if (kind == Source::kCanon) {
    const auto program = read_canon(in, name, machine);
    if (!program) return tl::unexpected(program.error());
    if (auto fits = check_tool(*program, job, name); !fits) return tl::unexpected(fits.error());
    return execute_program(*program, name, machine, job.setup, motion_options(job.machine));
  }
  if (kind == Source::kTrace) {
    const auto trace = read_trace(in, name);
    if (!trace) return tl::unexpected(trace.error());
    if (auto fits = check_trace(*trace, job, name); !fits) return tl::unexpected(fits.error());
    return executed_path(*trace, name, motion_options(job.machine));
  }
  return read_and_execute(in, name, job, header);
}

Result<void> check_probes(const pathgen::CheckedMesh& part, double spacing) {
  double area = 0.0;
  for (const auto& f : part.mesh.facets) {
    const auto& v = part.mesh.vertices;
    area += 0.5 * length(cross(v[f[1]] - v[f[0]], v[f[2]] - v[f[0]]));
  }
  const double need = area / (spacing * spacing) * static_cast<double>(kProbeBytes);
  const std::uint64_t have = free_bytes();
  if (have == 0 || need < 0.5 * static_cast<double>(have)) return {};
  return fail(Code::kLimit, "a resolution of " + number_text(spacing) + " mm needs about " +
                                std::to_string(static_cast<std::uint64_t>(need) >> 20) +
                                " MB for the part's surface, and " + std::to_string(have >> 20) +
                                " MB are free: use a coarser --resolution");
}

/// The part, and the probes on it.
struct Surface {
  std::optional<Error> error;
  pathgen::CheckedMesh part;
  double cell = 0.0;
  std::optional<Probes> probes;
};

Surface read_surface(const config::Job& job, std::optional<double> resolution) {
  Surface surface;
  const Result<pathgen::Stl> stl = pathgen::read_stl(job.stl_path, job.stl_unit_mm);
  if (!stl) return {stl.error(), {}, 0.0, {}};
  Result<pathgen::CheckedMesh> part =
      pathgen::check_mesh(*stl, {ToleranceBudget(job.plan.tolerance).repair()});
  if (!part) return {part.error(), {}, 0.0, {}};
  surface.part = std::move(*part);
  surface.cell = resolution ? *resolution : default_cell(job, surface.part);
  if (const auto fits = check_probes(surface.part, surface.cell); !fits) return {fits.error(), {}, 0.0, {}};
  surface.probes.emplace(surface.part.mesh, surface.cell, probe_reach(job, rest_limit(job.plan)));
  return surface;
}

/// The same stock in few lines, to be shown. Nothing where so few lines do not do: a thin part falls through.
std::optional<StockFilm> make_film(const StockShape& shape, const pathgen::CheckedMesh& part,
                                   const config::Job& job, const Stock& stock, const ExecutedPath& path,
                                   int threads) {
  const int axis = main_direction(path, job.machine.model, job.setup);
  const double cell = StockFilm::cell_for(stock.box, axis, stock.cell);
  auto coarse = make_stock(shape, part, job, cell, threads, {axis});
  if (!coarse) return std::nullopt;
  return StockFilm(std::move(coarse->bundles.front()), cell, path.moves.front().start, path.moves.back().end);
}

void print(const RemovalContext& context, const RemovalVerdict& verdict, const Removal& r) {
  std::printf("%s\n", verdict.word());
  for (const std::string& failure : verdict.failures) std::printf("  %s\n", failure.c_str());
  if (!verdict.rest.empty()) std::printf("  %s\n", verdict.rest.c_str());
  std::printf("  stock                  %s%s\n", to_string(context.stock).c_str(),
              context.stock_from.c_str());
  std::printf("  largest gouge          %.4f mm (tolerance %.4g mm)\n", verdict.gouge, verdict.tolerance);
  if (r.gouge.depth > 0.0) std::printf("    there                %s\n", trouble_text(r.gouge).c_str());
  std::printf("  left on %.0f of %.0f mm2  median %.4f, 95 %% %.4f, 99 %% %.4f mm\n", r.touched_area, r.area,
              r.excess[3], r.excess[5], r.excess[6]);
  std::printf(
      "  over the limit         %.0f mm2 in the tool's reach, %.0f mm2 out of it, containment and tilt limit "
      "counted (limit %.4f mm)\n",
      r.rest.area, r.rest.out_of_reach, r.rest.limit);
  std::printf("  removed                %.1f of %.1f mm3\n", r.stock_volume - r.left_volume, r.stock_volume);
  std::printf("  machining time         %.1f s, rapids %.1f s, air %.1f %% of the feed moves\n", r.seconds,
              r.rapid_seconds, r.feed_seconds > 0.0 ? 100.0 * r.air_seconds / r.feed_seconds : 0.0);
}

double since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

/// `read`, `cut`: when reading and cutting ended, s.
void print_cost(std::chrono::steady_clock::time_point begun, double read, double cut) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  const double all = since(begun);
  std::printf("  took                   %.2f s (reading and stock %.2f, cutting %.2f, report %.2f), ", all,
              read, cut - read, all - cut);
  std::printf("processor %.2f s, %.0f MB\n", seconds(usage.ru_utime) + seconds(usage.ru_stime),
              static_cast<double>(usage.ru_maxrss) / 1024.0);
}

}  // namespace

int verify_command(const VerifyOptions& options) {
  const auto begun = std::chrono::steady_clock::now();
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, cancel_simulation);
  if (!options.program.empty() + !options.trace.empty() + !options.canon.empty() != 1)
    return report({Code::kUsage, "a program, --trace or --canon, one of them; see --help"});
  if (options.resolution && !(*options.resolution >= kFinest && *options.resolution <= kCoarsest))
    return report({Code::kUsage, "--resolution " + number_text(*options.resolution) + ": " +
                                     number_text(kFinest) + " to " + number_text(kCoarsest) + " mm"});
  VerifyProgress line(options.progress);
  line.show("read", 0.0);
  const Result<config::Job> job = config::load_job_with(options.job, {options.stl, options.machine});
  if (!job) return report(job.error());
  if (is_page(options.out)) {
    std::vector<config::NamedFile> inputs = config::files_of(*job);
    inputs.insert(inputs.end(), {{"PROGRAM", options.program},
                                 {"--trace", options.trace},
                                 {"--canon", options.canon},
                                 {"--stock", options.stock}});
    if (const auto fits = config::check_outputs({{"--out", options.out}}, inputs); !fits)
      return report(fits.error());
  }
  auto shape = options.stock.empty() ? Result<StockShape>(default_stock(*job)) : parse_stock(options.stock);
  if (!shape) return report(shape.error());
  RemovalOptions removal;
  removal.tolerance = job->plan.tolerance, removal.rest_limit = rest_limit(job->plan);
  removal.threads = options.threads > 0 ? options.threads
                                        : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Surface surface;
  ProgramHeader header;
  Result<ExecutedPath> path = fail(Code::kInput, "not read");
  in_parallel(2, removal.threads, [&](std::size_t task) {
    if (task == 0)
      surface = read_surface(*job, options.resolution);
    else
      path = read_path(options, *job, header);
  });
  if (surface.error) return report(*surface.error);
  if (!path) return report(path.error());
  const pathgen::CheckedMesh* part = &surface.part;
  const double cell = surface.cell;
  if (options.stock.empty() && shape->kind == StockKind::kOffset && part->sides != pathgen::Sides::kOutward)
    shape = StockShape{StockKind::kBox, shape->margin, {}}, removal.stock_known = false;
  const Moves moves = moves_of(options);
  const RemovalContext context{
      *job, *part, *shape, moves.name, header, moves.kind, options.stock.empty() ? stock_from(removal) : ""};
  line.show("stock", 0.0);
  std::vector<int> axes{0, 1, 2};
  if (options.bundles == 1) axes = {main_direction(*path, job->machine.model, job->setup)};
  auto stock = make_stock(*shape, *part, *job, cell, removal.threads, axes);
  if (!stock) return report(stock.error());
  std::optional<StockFilm> film;
  if (!options.out.empty()) {
    if (!is_page(options.out))
      if (auto made = make_report_folder(options.out); !made) return report(made.error());
    film = make_film(*shape, *part, *job, *stock, *path, removal.threads);
  }
  const double read = since(begun);
  Probes& probes = *surface.probes;
  std::future<Drawings> drawings;
  if (!options.out.empty())
    drawings = std::async(removal.threads > 1 ? std::launch::async : std::launch::deferred,
                          [&] { return draw_report(*job, *part, *path, probes.patches()); });
  const auto result = remove_material(
      *job, *path, *stock, probes, removal,
      [&](const char* stage, double f) {
        line.show(stage, f);
        return true;
      },
      film ? &*film : nullptr);
  if (!result) return report(result.error());
  const RemovalVerdict verdict = judge(*result, context);
  const double cut = since(begun);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_IGN);  // the rest is quick, and whole
  if (options.as_json)
    std::printf("%s\n", to_json(context, *result, verdict).c_str());
  else
    print(context, verdict, *result);
  if (!options.out.empty()) {
    line.show("report", 0.0);
    const RemovalFindings findings{context, drawings.get(),         *result, verdict, *path,
                                   probes,  film ? &*film : nullptr};
    if (auto written = write_removal_report(options.out, findings, removal.threads); !written)
      return report(written.error());
  }
  if (!options.as_json) print_cost(begun, read, cut);
  return verdict.passed() ? kDone : verdict.incomplete() ? kIncomplete : kFailed;
}

}  // namespace tiltfeed::sim
