#include "sim/report/verify_command.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <future>
#include <iostream>
#include <optional>
#include <string_view>
#include <thread>

#include "config/job.h"
#include "config/job_inputs.h"
#include "config/part_faces.h"
#include "config/part_reading.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/basics/workers.h"
#include "sim/removal/executed_path.h"
#include "sim/removal/removal.h"
#include "sim/removal/stock.h"
#include "sim/report/program_header.h"
#include "sim/report/report.h"
#include "sim/report/verified_moves.h"
#include "sim/report/verify_progress.h"

namespace tiltfeed::sim {
namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2, kIncomplete = 3;
constexpr double kFinest = 1e-3, kCoarsest = 50.0;

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

/// Why the stock is what nobody said that it is.
std::string stock_from(const config::Job& job, const RemovalOptions& options) {
  if (job.blank && job.operation.number == 1) return ", the job's blank";
  return options.stock_known
             ? ", taken from the job's approach_mm and pattern; --stock says another"
             : ", taken as the part is open: what touches it is not judged; --stock gives one";
}

/// The one file that says the moves.
MovesFile moves_of(const VerifyOptions& o) {
  if (!o.program.empty()) return {Source::kProgram, o.program};
  if (!o.trace.empty()) return {Source::kTrace, o.trace};
  return {Source::kCanon, o.canon};
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

/// A folder or page by itself for each of several operations.
std::string out_of(const std::string& out, const config::OperationName& operation) {
  if (out.empty() || operation.count == 1) return out;
  const std::string page = ".html", name = std::to_string(operation.number) + "-" + operation.name;
  return is_page(out) ? out.substr(0, out.size() - page.size()) + "-" + name + page : out + "/" + name;
}

void print(const RemovalContext& context, const RemovalVerdict& verdict, const Removal& r) {
  std::printf("%s\n", verdict.word());
  for (const std::string& failure : verdict.failures) std::printf("  %s\n", failure.c_str());
  if (!verdict.rest.empty()) std::printf("  %s\n", verdict.rest.c_str());
  if (!verdict.unseen.empty()) std::printf("  not seen: %s\n", verdict.unseen.c_str());
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
  if (r.rest.elsewhere > 0.0)
    std::printf(
        "  other directions       %.0f mm2 of what is out of reach: more of them, or those of axis free\n",
        r.rest.elsewhere);
  std::printf("  removed                %.1f of %.1f mm3, %.1f left\n", r.stock_volume - r.left_volume,
              r.stock_volume, r.left_volume);
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

/// One program, operation by operation.
class Verification {
 public:
  Verification(const VerifyOptions& options, VerifyProgress& line) : options_(options), line_(line) {}
  /// The exit status.
  Result<int> run();

 private:
  Result<void> load();
  Result<void> read();
  Result<void> make_first_stock();
  Result<void> verify(std::size_t operation);
  /// The part of an operation, in part_; its job knows the faces that it is for.
  Result<void> take_part(config::Job& job);
  void show(const RemovalContext& context, const RemovalVerdict& verdict, const Removal& result);
  void take(const RemovalVerdict& verdict);
  bool several() const { return jobs_.size() > 1; }

  const VerifyOptions& options_;
  VerifyProgress& line_;
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::vector<config::Job> jobs_;
  StockShape shape_;
  RemovalOptions removal_;
  config::PartsByTolerance parts_;
  const pathgen::CheckedMesh* part_ = nullptr;  ///< as the operation that is verified has it
  VerifiedMoves moves_;
  double cell_ = 0.0;
  std::optional<Stock> stock_;  ///< as the operations before have left it
  std::optional<StockFilm> film_;
  double read_ = 0.0, cut_ = 0.0;  ///< when reading and cutting ended, s
  bool failed_ = false, incomplete_ = false;
  std::string reports_;  ///< JSON of the operations, with commas between them
};

Result<void> Verification::load() {
  line_.show("read", 0.0);
  auto jobs = config::load_operations(
      options_.job, {.stl = options_.stl, .machine = options_.machine, .operation = options_.operation});
  if (!jobs) return tl::unexpected(jobs.error());
  jobs_ = std::move(*jobs);
  for (const config::Job& job : jobs_) {
    if (!is_page(options_.out)) continue;
    std::vector<config::NamedFile> inputs = config::files_of(job);
    inputs.insert(inputs.end(), {{"PROGRAM", options_.program},
                                 {"--trace", options_.trace},
                                 {"--canon", options_.canon},
                                 {"--stock", options_.stock}});
    if (const auto fits = config::check_outputs({{"--out", out_of(options_.out, job.operation)}}, inputs);
        !fits)
      return fits;
  }
  auto shape =
      options_.stock.empty() ? Result<StockShape>(default_stock(jobs_.front())) : parse_stock(options_.stock);
  if (!shape) return tl::unexpected(shape.error());
  shape_ = *shape;
  removal_.threads = options_.threads > 0
                         ? options_.threads
                         : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return {};
}

Result<void> Verification::read() {
  Result<const pathgen::CheckedMesh*> part = fail(Code::kInput, "not read");
  Result<VerifiedMoves> moves = fail(Code::kInput, "not read");
  in_parallel(2, removal_.threads, [&](std::size_t task) {
    if (task == 0)
      part = parts_.of(jobs_.front());
    else
      moves = read_moves(moves_of(options_), jobs_);
  });
  if (!part) return tl::unexpected(part.error());
  part_ = *part;
  cell_ = options_.resolution.value_or(kCoarsest);
  if (!options_.resolution)
    for (const config::Job& job : jobs_) cell_ = std::min(cell_, default_cell(job, *part_));
  if (auto fits = check_probes(*part_, cell_); !fits) return fits;
  if (!moves) return tl::unexpected(moves.error());
  moves_ = std::move(*moves);
  return {};
}

Result<void> Verification::make_first_stock() {
  const config::Job& job = jobs_.front();
  if (options_.stock.empty() && shape_.kind == StockKind::kOffset && part_->sides != pathgen::Sides::kOutward)
    shape_ = StockShape{StockKind::kBox, shape_.margin, {}}, removal_.stock_known = false;
  line_.show("stock", 0.0);
  // One bundle does where all operations cut along it.
  const int axis = main_direction(moves_.paths.front(), job.machine.model, job.setup);
  bool one = options_.bundles == 1;
  for (std::size_t i = 1; i < jobs_.size(); ++i)
    one = one && main_direction(moves_.paths[i], jobs_[i].machine.model, jobs_[i].setup) == axis;
  auto stock = make_stock(shape_, *part_, job, cell_, removal_.threads,
                          one ? std::vector<int>{axis} : std::vector<int>{0, 1, 2});
  if (!stock) return tl::unexpected(stock.error());
  stock_ = std::move(*stock);
  if (options_.out.empty()) return {};
  if (!is_page(options_.out) && several())
    if (auto made = make_report_folder(options_.out); !made) return made;
  film_ = make_film(shape_, *part_, job, *stock_, moves_.paths.front(), removal_.threads);
  return {};
}

Result<void> Verification::take_part(config::Job& job) {
  const auto part = parts_.of(job);
  if (!part) return tl::unexpected(part.error());
  part_ = *part;
  return config::add_chosen_faces(job, parts_.model_of(job), *part_);
}

Result<void> Verification::verify(std::size_t operation) {
  if (auto taken = take_part(jobs_[operation]); !taken) return taken;
  const config::Job& job = jobs_[operation];
  const ExecutedPath& path = moves_.paths[operation];
  if (operation > 0 && film_)
    film_ = StockFilm(Dexels(film_->lines()), film_->cell(), path.moves.front().start, path.moves.back().end);
  removal_.tolerance = job.plan.tolerance,
  removal_.rest_limit = asks_all(job.plan) ? rest_limit(job.plan) : -1.0;
  Probes probes(part_->mesh, cell_, probe_reach(job, rest_limit(job.plan)));
  ProgramHeader header = moves_.header;
  if (several()) header.blocks = {}, header.seconds = {};
  const RemovalContext context{job,
                               *part_,
                               shape_,
                               moves_of(options_).name,
                               header,
                               moves_of(options_).kind,
                               operation > 0            ? ", less what the operations before have cut"
                               : options_.stock.empty() ? stock_from(job, removal_)
                                                        : ""};
  const std::string out = out_of(options_.out, job.operation);
  if (!out.empty() && !is_page(out))
    if (auto made = make_report_folder(out); !made) return made;
  if (operation == 0) read_ = since(begun_);
  std::future<Drawings> drawings;
  if (!out.empty())
    drawings = std::async(removal_.threads > 1 ? std::launch::async : std::launch::deferred,
                          [&] { return draw_report(job, *part_, path, probes.patches()); });
  const auto result = remove_material(
      job, path, *stock_, probes, removal_,
      [&](const char* stage, double f) {
        line_.show(stage, f);
        return true;
      },
      film_ ? &*film_ : nullptr);
  if (!result) return tl::unexpected(result.error());
  RemovalVerdict verdict = judge(*result, context);
  std::uint64_t blocks = 1;
  for (const ExecutedPath& one : moves_.paths) blocks += one.blocks();
  if (several() && operation == 0 && moves_.header.blocks && *moves_.header.blocks != blocks)
    verdict.failures.push_back("the program has " + std::to_string(blocks) +
                               " blocks that move an axis, its header states " +
                               std::to_string(*moves_.header.blocks));
  cut_ = since(begun_);
  if (operation + 1 == jobs_.size())
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_IGN);  // the rest is quick, and whole
  take(verdict);
  show(context, verdict, *result);
  if (out.empty()) return {};
  line_.show("report", 0.0);
  const RemovalFindings findings{context, drawings.get(),           *result, verdict, path,
                                 probes,  film_ ? &*film_ : nullptr};
  return write_removal_report(out, findings, removal_.threads);
}

void Verification::take(const RemovalVerdict& verdict) {
  failed_ = failed_ || (!verdict.passed() && !verdict.incomplete());
  incomplete_ = incomplete_ || verdict.incomplete();
}

void Verification::show(const RemovalContext& context, const RemovalVerdict& verdict, const Removal& result) {
  const config::OperationName& operation = context.job.operation;
  if (options_.as_json) {
    reports_ += (reports_.empty() ? "" : ",\n") + to_json(context, result, verdict);
    return;
  }
  if (!operation.name.empty())
    std::printf("operation %zu of %zu, %s: ", operation.number, operation.count, operation.name.c_str());
  print(context, verdict, result);
}

Result<int> Verification::run() {
  for (const auto stage : {&Verification::load, &Verification::read, &Verification::make_first_stock})
    if (auto done = (this->*stage)(); !done) return tl::unexpected(done.error());
  for (std::size_t i = 0; i < jobs_.size(); ++i)
    if (auto done = verify(i); !done) return tl::unexpected(done.error());
  const char* const word = failed_ ? "failed" : incomplete_ ? "incomplete" : "passed";
  if (options_.as_json && several())
    std::printf("{\n\"passed\": %s,\n\"verdict\": \"%s\",\n\"operations\": [\n%s\n]\n}\n",
                failed_ || incomplete_ ? "false" : "true", word, reports_.c_str());
  else if (options_.as_json)
    std::printf("%s\n", reports_.c_str());
  else
    print_cost(begun_, read_, cut_);
  return failed_ ? kFailed : incomplete_ ? kIncomplete : kDone;
}

}  // namespace

int verify_command(const VerifyOptions& options) {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, cancel_simulation);
  if (!options.program.empty() + !options.trace.empty() + !options.canon.empty() != 1)
    return report({Code::kUsage, "a program, --trace or --canon, one of them; see --help"});
  if (options.resolution && !(*options.resolution >= kFinest && *options.resolution <= kCoarsest))
    return report({Code::kUsage, "--resolution " + number_text(*options.resolution) + ": " +
                                     number_text(kFinest) + " to " + number_text(kCoarsest) + " mm"});
  VerifyProgress line(options.progress);
  const Result<int> status = Verification(options, line).run();
  return status ? *status : report(status.error());
}

}  // namespace tiltfeed::sim
