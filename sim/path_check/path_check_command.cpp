#include "sim/path_check/path_check_command.h"

#include <cstdio>
#include <fstream>
#include <iterator>

#include "config/job.h"
#include "config/job_inputs.h"
#include "config/output_file.h"
#include "config/part_reading.h"
#include "kinematics/cl_text/cl_file.h"
#include "pathgen/mesh/mesh.h"
#include "sim/basics/write_bytes.h"
#include "sim/gcode/canon.h"
#include "sim/motion/dry_run.h"
#include "sim/path_check/path_check.h"
#include "sim/picture/picture.h"

namespace tiltfeed::sim {
namespace {

/// Opens `path` and reads it with `read(stream, path)`.
template <class Read>
auto read_file(const std::string& path, const Read& read)
    -> decltype(read(std::declval<std::istream&>(), path)) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::kIo, path + ": cannot be opened");
  return read(in, path);
}

void print(const PathCheckReport& r) {
  const auto line = [](const char* what, const Extreme& worst, const char* unit) {
    std::printf("  %-16s %.6f %s (block %llu, line %u)\n", what, worst.value, unit,
                static_cast<unsigned long long>(worst.place.block), worst.place.line);
  };
  std::printf("%s\n", r.passed() ? "passed" : "FAILED");
  std::printf(
      "  blocks           %llu of %llu executed, %llu missing, %llu repeated, %llu altered\n",
      static_cast<unsigned long long>(r.program.executed), static_cast<unsigned long long>(r.program.blocks),
      static_cast<unsigned long long>(r.program.missing), static_cast<unsigned long long>(r.program.repeated),
      static_cast<unsigned long long>(r.program.altered));
  line("gouge", r.gouge, "mm");
  line("rapid overlap", r.rapid_overlap, "mm");
  line("gap", r.gap, "mm");
  line("tip deviation", r.tip_deviation, "mm");
  line("axis deviation", r.axis_deviation, "degrees");
  std::printf("  machine time     %.3f s\n", r.seconds);
  const auto peaks = [](const char* what, const std::array<double, 5>& p) {
    std::printf("  %-16s X %.0f Y %.0f Z %.0f tilt %.0f rotary %.0f\n", what, p[0], p[1], p[2], p[3], p[4]);
  };
  peaks("peak, per min", r.peaks.speed);
  peaks("peak, per s^2", r.peaks.acceleration);
  for (const std::string& failure : r.failures) std::printf("  %s\n", failure.c_str());
}

Result<std::vector<Block>> read_blocks(const PathCheckFiles& files, const MachineModel& machine) {
  if (files.program.empty() == files.canon.empty())
    return fail(Code::kUsage, "check-path: one of --program and --canon is needed; see --help");
  if (files.program.empty())
    return read_file(files.canon, [&](std::istream& in, const std::string& name) {
      return read_canon(in, name, machine);
    });
  return read_file(files.program, [&](std::istream& in, const std::string& name) {
    return read_program(in, name, GcodeReader(machine));
  });
}

Result<std::vector<TraceRow>> rows_of(const PathCheckFiles& files, const std::vector<Block>& program,
                                      const config::Job& job) {
  if (!files.trace.empty()) return read_file(files.trace, read_trace);
  Result<DryRun> run = dry_run(program, files.canon.empty() ? files.program : files.canon, job.machine.model,
                               job.setup, motion_options(job.machine));
  if (!run) return tl::unexpected(run.error());
  return std::move(run->rows);
}

Result<void> draw(const PathCheckFiles& files, const config::Job& job, const pathgen::Mesh& part,
                  const ToolPath& path) {
  std::string report;
  if (!files.report.empty()) {
    const auto read =
        read_file(files.report, [](std::istream& in, const std::string&) -> Result<std::string> {
          return std::string{std::istreambuf_iterator<char>(in), {}};
        });
    if (!read) return tl::unexpected(read.error());
    report = *read;
  }
  auto marks = facet_marks(part, job, path, report);
  if (!marks) return fail(marks.error().code, files.report + ": " + marks.error().message);
  PictureOptions options;
  options.marks = std::move(*marks);
  return draw_part_with_path(part, path, files.picture, options);
}

}  // namespace

Result<bool> path_check_command(const PathCheckFiles& files) {
  const Result<config::Job> job = config::load_job(files.job);
  if (!job) return tl::unexpected(job.error());
  std::vector<config::NamedFile> inputs = config::files_of(*job);
  inputs.insert(inputs.end(), {{"--program", files.program},
                               {"--canon", files.canon},
                               {"--cl", files.cl},
                               {"--trace", files.trace},
                               {"--report", files.report}});
  const auto fits = config::check_outputs({{"--picture", files.picture}, {"--out", files.json}}, inputs);
  if (!fits) return tl::unexpected(fits.error());
  const Result<pathgen::CheckedMesh> part = config::read_part(*job);
  if (!part) return tl::unexpected(part.error());
  const auto program = read_blocks(files, job->machine.model);
  if (!program) return tl::unexpected(program.error());
  const auto planned = read_file(files.cl, read_cl);
  if (!planned) return tl::unexpected(planned.error());
  const auto trace = rows_of(files, *program, *job);
  if (!trace) return tl::unexpected(trace.error());

  const auto verified =
      check_path(*job, part->mesh, *program, *planned, *trace, {}, [](const char*, double) { return true; });
  if (!verified) return tl::unexpected(verified.error());
  print(*verified);
  if (!files.json.empty())
    if (const auto written = write_bytes(files.json, to_json(*verified)); !written)
      return tl::unexpected(written.error());
  if (!files.picture.empty())
    if (const auto drawn = draw(files, *job, part->mesh, *planned); !drawn)
      return tl::unexpected(drawn.error());
  return verified->passed();
}

}  // namespace tiltfeed::sim
