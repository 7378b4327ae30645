#include "daemon/command/post_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "config/output_file.h"
#include "daemon/command/command.h"
#include "daemon/plan/plan_text.h"
#include "daemon/post/nc_rules.h"
#include "daemon/post/post.h"
#include "daemon/post/text_drawing.h"
#include "daemon/post/unpost.h"
#include "kinematics/cl_text/apt_vocabulary.h"

namespace tiltfeed::daemon {
namespace {

constexpr double kInch = 25.4;  // mm, exactly
constexpr double kMost = 1e5;   // mm or degrees that an option may state
// Of the tolerance, what the chords of an arc may take; the machine's moves have the rest.
constexpr double kChordShare = 0.5;

Result<std::ifstream> opened(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::kIo, path + ": cannot be opened");
  return in;
}

Vec3 vector_of(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

/// Numbers of mm or degrees that mean something on a machine.
CLI::Validator finite(bool positive = false) {
  return CLI::Validator(
      [positive](const std::string& text) -> std::string {
        double value = 0.0;
        const bool read = CLI::detail::lexical_cast(text, value);
        if (read && std::abs(value) <= kMost && (value > 0.0 || !positive)) return "";
        const bool comma = text.find(',') != text.npos;
        return std::string(positive ? "expected a finite number above 0, up to 100000"
                                    : "expected a finite number up to 100000") +
               ", found " + text + (comma ? "; write decimals with a point" : "");
      },
      positive ? "NUMBER above 0" : "NUMBER");
}

void list_dialects() {
  for (const config::DialectName& one : config::kDialects)
    std::cout << one.name << "\t" << one.control << "\n";
}

int show_dialects() {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const config::DialectName& one : config::kDialects)
    list.push_back({{"name", one.name}, {"control", one.control}});
  return show_json(nlohmann::ordered_json({{"dialects", list}}).dump());
}

}  // namespace

struct PostCommands::Options {
  CLI::App *post = nullptr, *unpost = nullptr;
  std::string input, machine, output, drawing, dialect, unit, smoothing;
  std::vector<std::string> ignored;
  double feed = 0.0;
  bool as_json = false, list = false, tcp = false, no_tcp = false, planes = false, no_planes = false;
  double tolerance = 0.0, axis_tolerance = 0.0, tool_length = 0.0;
  ClearSpace clear;
  std::vector<double> part_zero, fixture;
  config::ProgramData data;

  Result<config::MachineProfile> profile() const;
  Result<void> check_files() const;
  /// The program itself, or a drawing, goes to the standard output.
  bool takes_output() const { return output == "-" || drawing == "-"; }
  std::ostream& said() const { return takes_output() ? std::cerr : std::cout; }
  /// With --json. The standard output may be taken by the program itself.
  int show(nlohmann::ordered_json object) const;
  Result<void> take_data();
  int run_post();
  int run_unpost() const;
};

int PostCommands::Options::show(nlohmann::ordered_json object) const {
  object["out"] = output;
  const std::string text = object.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  if (!takes_output()) return show_json(text);
  std::cerr << text << "\n";
  return kExitDone;
}

/// The machine profile, with the dialect and TCP of the command line.
Result<config::MachineProfile> PostCommands::Options::profile() const {
  std::optional<config::Dialect> wanted;
  for (const config::DialectName& one : config::kDialects)
    if (dialect == one.name) wanted = one.dialect;
  if (!dialect.empty() && !wanted)
    return fail(Code::kUsage,
                "--dialect " + dialect + " is not known; `tiltfeed post --list-dialects` lists them");
  auto profile = config::load_machine(machine, wanted);
  if (!profile) return profile;
  if (tcp && !config::has_tcp(profile->format.dialect))
    return fail(Code::kUsage, std::string("--tcp: ") + config::name_of(profile->format.dialect).name +
                                  " has no words for TCP");
  if (tcp && !profile->model.tilt.present && !profile->model.rotary.present)
    return fail(Code::kUsage, "--tcp: " + profile->model.name + " has no rotary axis");
  const config::Dialect control = profile->format.dialect;
  if (const int most = config::most_work_offsets(control); data.work_offset > most)
    return fail(Code::kUsage, "--work-offset " + std::to_string(data.work_offset) + ": " +
                                  config::name_of(control).name + " programs can call " +
                                  std::to_string(most));
  if (tcp || no_tcp) profile->format.tcp = tcp;
  for (const auto& [key, wrong] : config::not_of_control(data, profile->format, profile->path))
    if (key == std::string_view("smoothing")) return fail(Code::kUsage, "--smoothing: " + wrong);
  if (data.arc_tolerance > 0.0 && profile->format.tcp && !planes && !profile->format.tilted_planes)
    return fail(Code::kUsage,
                "--arc-tolerance: under TCP X Y Z are the tip's, and no arc is posted; say --no-tcp");
  if (planes || no_planes) profile->format.tilted_planes = planes;
  if (const auto why = planes ? config::no_planes(profile->model, profile->format) : std::nullopt)
    return fail(Code::kUsage, "--planes: " + *why);
  for (const auto& [key, wrong] : config::not_of_control(data, profile->format, profile->path))
    if (key == std::string_view("plane_offsets")) return fail(Code::kUsage, "--plane-offsets: " + wrong);
  return profile;
}

/// Before any work. "-" is the standard output; what the command says then goes to standard error.
Result<void> PostCommands::Options::check_files() const {
  return config::check_outputs({{"--out", output}, {"--drawing", drawing}},
                               {{"IN", input}, {"--machine", machine}});
}

/// What is told by words and figures of its own. Errors: kUsage.
Result<void> PostCommands::Options::take_data() {
  const auto between = [](const char* option, double value, double least, double most) -> Result<void> {
    if (value >= least && value <= most) return {};
    return fail(Code::kUsage, std::string(option) + " " + decimal(value, 6) + ": expected " +
                                  decimal(least, 4) + " to " + decimal(most, 4) + " mm");
  };
  if (!smoothing.empty()) {
    const auto word = config::smoothing_of(smoothing);
    if (!word || *word == config::Smoothing::kNone)
      return fail(Code::kUsage, "--smoothing " + smoothing + ": expected rough, semi or finish");
    data.smoothing = *word;
  }
  if (smoothing.empty() != (post->count("--smoothing-tolerance") == 0))
    return fail(Code::kUsage, "--smoothing and --smoothing-tolerance belong together; state both or none");
  if (!smoothing.empty())
    if (auto fits = between("--smoothing-tolerance", data.smoothing_tolerance, config::kLeastSmoothing,
                            config::kMostSmoothing);
        !fits)
      return fits;
  if (post->count("--arc-tolerance") == 0) return {};
  return between("--arc-tolerance", data.arc_tolerance, config::kLeastArcTolerance,
                 config::kMostArcTolerance);
}

int PostCommands::Options::run_post() {
  if (auto taken = take_data(); !taken) return complain(taken.error());
  const auto profile = this->profile();
  if (!profile) return complain(profile.error());
  auto in = opened(input);
  if (!in) return complain(in.error());
  PostOptions options;
  if (tolerance > 0.0) options.tolerance = tolerance;
  const auto program = read_apt(*in, input,
                                {unit == "inch" ? kInch : (unit == "mm" ? 1.0 : 0.0), tool_length, feed,
                                 options.tolerance * kChordShare, ignored});
  if (!program) return complain(program.error());
  for (const std::string& note : program->notes) std::cerr << "tiltfeed: note: " << note << "\n";
  for (const AptOperation& op : program->operations)
    if (tool_length > 0.0 && op.path.tool.length != tool_length)
      std::cerr << "tiltfeed: note: --tool-length " << decimal(tool_length, 4) << " is not taken for tool "
                << op.tool_number << ": " << input << " states LENGTH " << decimal(op.path.tool.length, 4)
                << " mm\n";
  if (axis_tolerance > 0.0) options.axis_tolerance = axis_tolerance;
  if (!part_zero.empty()) options.setup.part_zero = vector_of(part_zero);
  if (!fixture.empty()) options.setup.fixture = fixture_of(vector_of(fixture));
  options.clear = clear;
  options.data = data;
  const auto posted = daemon::post(*program, input, *profile, options);
  if (!posted) return complain(posted.error());
  auto file = config::OutputFile::open(output);
  if (!file) return complain(file.error());
  const auto written = write_program(posted->posting, file->stream());
  if (auto flushed = file->flush(); !flushed) return complain(flushed.error());
  if (!written) return complain(written.error());
  if (auto kept = file->commit(); !kept) return complain(kept.error());
  std::size_t moves = 0;
  for (const AptOperation& op : program->operations) moves += op.path.moves.size();
  const Starvation waits = starved(posted->timing, *profile, *written);
  if (as_json)
    return show({{"operations", program->operations.size()},
                 {"moves", moves},
                 {"axis_deviation_deg", posted->report.max_axis_deviation},
                 {"motion", motion_text({profile->model, posted->report, *written, posted->timing, waits})},
                 {"notes", program->notes}});
  std::fprintf(takes_output() ? stderr : stdout,
               "%zu operations, %zu moves, the axis within %.4f degrees between blocks\n",
               program->operations.size(), moves, posted->report.max_axis_deviation);
  said() << motion_text({profile->model, posted->report, *written, posted->timing, waits});
  return kExitDone;
}

int PostCommands::Options::run_unpost() const {
  const auto profile = this->profile();
  if (!profile) return complain(profile.error());
  auto in = opened(input);
  if (!in) return complain(in.error());
  const auto text = read_nc_program(*in, input, text_language(*profile));
  if (!text) return complain(text.error());
  UnpostOptions options;
  if (tolerance > 0.0) options.tolerance = tolerance;
  if (axis_tolerance > 0.0) options.axis_tolerance = axis_tolerance;
  if (tool_length > 0.0) options.tool_length = tool_length;
  if (!part_zero.empty()) options.part_zero = vector_of(part_zero);
  if (!fixture.empty()) options.fixture_deg = vector_of(fixture);
  const auto program = daemon::unpost(*text, *profile, options);
  if (!program) return complain({program.error().code, input + ": " + program.error().message});
  for (const std::string& note : program->notes) std::cerr << "tiltfeed: note: " << note << "\n";
  for (const auto& [path, write] : {std::pair{&output, &write_apt}, {&drawing, &write_text_drawing}}) {
    if (path->empty()) continue;
    auto file = config::OutputFile::open(*path);
    if (!file) return complain(file.error());
    write(*program, file->stream());
    if (auto kept = file->commit(); !kept) return complain(kept.error());
  }
  std::size_t blocks = 0, moves = 0;
  for (const TextOperation& op : text->operations) blocks += op.blocks.size();
  for (const AptOperation& op : program->operations) moves += op.path.moves.size();
  if (as_json)
    return show({{"operations", text->operations.size()},
                 {"blocks", blocks},
                 {"points", moves},
                 {"notes", program->notes}});
  std::fprintf(takes_output() ? stderr : stdout, "%zu operations, %zu blocks, %zu points\n",
               text->operations.size(), blocks, moves);
  return kExitDone;
}

PostCommands::PostCommands(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.post =
      app.add_subcommand("post", "write the machine's program from a CL file of any CAM system (APT text)");
  o.unpost = app.add_subcommand("unpost", "write the tool path that a program really makes as a CL file");
  for (CLI::App* one : {o.post, o.unpost}) {
    const bool posts = one == o.post;
    one->add_option("IN", o.input, posts ? "CL file (APT text)" : "program");
    one->add_option("--machine", o.machine, "machine profile (YAML)");
    one->add_option("--out", o.output, posts ? "program to write" : "CL file to write (APT text)");
    one->add_flag("--json", o.as_json, "print what was done as one JSON object");
    one->add_option("--dialect", o.dialect, "instead of the profile's");
    one->add_option("--tool-length", o.tool_length,
                    one == o.post ? "gauge line to tip, mm, of tools whose LOADTL/ states no LENGTH"
                                  : "gauge line to tip, mm")
        ->check(finite(true));
    one->add_option("--part-zero", o.part_zero, "from the table's axis to part zero, mm: X,Y,Z")
        ->expected(3)
        ->delimiter(',')
        ->check(finite());
    one->add_option("--fixture", o.fixture, "turn of the part about the table's x, y, z, degrees: RX,RY,RZ")
        ->expected(3)
        ->delimiter(',')
        ->check(finite());
    one->add_option("--tolerance", o.tolerance, "of the tip between points, mm")->check(finite(true));
    one->add_option("--axis-tolerance", o.axis_tolerance, "of the axis between points, degrees")
        ->check(finite(true));
  }
  o.unpost->add_option("--drawing", o.drawing,
                       "points of the tool path for a viewer, as float32; without --out alone");
  o.post
      ->add_option(
          "--clear-height", o.clear.height,
          "nothing on the table reaches higher above part zero, mm: the tool comes and leaves from there, "
          "and may be taken off in between to turn a rotary back")
      ->check(finite());
  o.post
      ->add_option(
          "--clear-radius", o.clear.radius,
          "nothing on the table reaches further from its axis, mm: a tool that lies may be taken off "
          "sideways to turn the table back")
      ->check(finite(true));
  o.post->add_flag("--tcp", o.tcp, "tool centre point by the control (G43.4, G234, TRAORI, M128)");
  o.post->add_flag("--no-tcp", o.no_tcp, "joint words, whatever the profile says")->excludes("--tcp");
  o.post->add_flag(
      "--planes", o.planes,
      "where the rotaries stand in every cut, the control's tilted planes (G68.2, G254, CYCLE800, "
      "PLANE SPATIAL)");
  o.post->add_flag("--no-planes", o.no_planes, "none, whatever the profile says")->excludes("--planes");
  o.post->add_flag("--plane-offsets", o.data.plane_offsets,
                   "each tilted plane with a work offset of its own, from --work-offset on; all are set to "
                   "part zero");
  o.post->add_option("--units", o.unit, "of a file without UNITS/: mm or inch")
      ->check(CLI::IsMember({"mm", "inch"}));
  o.post->add_option("--feed", o.feed, "of feed moves before the file states one, mm/min")
      ->check(finite(true));
  o.post->add_option("--ignore", o.ignored, "words of the file to leave out: CSYS, CUTCOM, ...")
      ->delimiter(',')
      ->check([](const std::string& word) {
        return is_motion_word(word) ? word + " moves the tool and cannot be left out" : "";
      });
  o.post->add_option("--tool", o.data.tool, "tool number where the file states none")
      ->check(CLI::Range(0, 9999));
  o.post->add_option("--number", o.data.number, "program number (O word)")->check(CLI::Range(1, 9999));
  o.post->add_option("--work-offset", o.data.work_offset, "1 is G54; what comes behind G59 counts on from 7")
      ->check(CLI::Range(1, config::kMostWorkOffsets));
  o.post->add_option("--smoothing", o.smoothing, "the control's high-speed function: rough, semi or finish");
  o.post->add_option(
      "--smoothing-tolerance", o.data.smoothing_tolerance,
      "what the control may leave the path by with it, 0.001 to 1 mm; it is taken of --tolerance");
  o.post->add_option(
      "--arc-tolerance", o.data.arc_tolerance,
      "arcs (G2, G3) where the rotaries stand and TCP is off: what they may leave the straight "
      "blocks by, 0.0005 to 1 mm; it is taken of --tolerance");
  o.post->add_flag("--list-dialects", o.list, "list the dialects and stop");
}

PostCommands::~PostCommands() = default;

bool PostCommands::called() const { return options_->post->parsed() || options_->unpost->parsed(); }

int PostCommands::run() const {
  Options& o = *options_;
  if (o.list && o.as_json) return show_dialects();
  if (o.list) return list_dialects(), kExitDone;
  for (const auto& [name, value] :
       {std::pair{"IN", &o.input}, {"--machine", &o.machine}, {"--out", &o.output}})
    if (value->empty() && (value != &o.output || o.drawing.empty()))
      return complain({Code::kUsage, std::string(name) + " is required; --help lists the options"});
  if (auto fits = o.check_files(); !fits) return complain(fits.error());
  return o.post->parsed() ? o.run_post() : o.run_unpost();
}

}  // namespace tiltfeed::daemon
