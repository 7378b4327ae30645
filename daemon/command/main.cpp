// The program `tiltfeed`: its command line.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "config/command_line.h"
#include "config/job.h"
#include "config/part_reading.h"
#include "config/standard_output.h"
#include "config/version.h"
#include "daemon/command/command.h"
#include "daemon/command/doctor_command.h"
#include "daemon/command/hand_over.h"
#include "daemon/command/history_command.h"
#include "daemon/command/init_command.h"
#include "daemon/command/interrupt.h"
#include "daemon/command/machine_command.h"
#include "daemon/command/manual_command.h"
#include "daemon/command/measure_command.h"
#include "daemon/command/metrics_command.h"
#include "daemon/command/mtconnect_command.h"
#include "daemon/command/plan_command.h"
#include "daemon/command/post_command.h"
#include "daemon/command/send_command.h"
#include "daemon/command/service_command.h"
#include "daemon/command/shop_command.h"
#include "daemon/command/suggest_command.h"
#include "daemon/command/support_command.h"
#include "daemon/command/tool_command.h"
#include "daemon/command/tools_command.h"
#include "daemon/plan/part_size.h"
#include "daemon/post/tool_length.h"
#include "pathgen/mesh/mesh.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::daemon;

/// "key: value" lines as one object.
nlohmann::ordered_json as_object(const std::string& lines) {
  nlohmann::ordered_json object;
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);)
    if (const std::size_t colon = line.find(": "); colon != line.npos)
      object[line.substr(0, colon)] = line.substr(colon + 2);
  return object;
}

int check_command(const std::string& path, bool as_json) {
  const auto jobs = config::load_operations(path, {});
  if (!jobs) return complain(jobs.error());
  const config::Job* const job = &jobs->front();
  for (const config::Job& one : *jobs)
    if (!as_json) std::cout << describe(one) << std::flush;
  auto model = config::read_part_model(*job);
  if (!model) return complain(model.error());
  const auto part = config::check_part(*job, *model);
  if (!part) return complain(part.error());
  const std::vector<std::string> notes = pathgen::notes_on(*model);
  if (as_json) {
    nlohmann::ordered_json described = as_object(describe(*job));
    if (jobs->size() > 1) {
      described = nlohmann::ordered_json::array();
      for (const config::Job& one : *jobs) described.push_back(as_object(describe(one)));
    }
    nlohmann::ordered_json json = {{"job", std::move(described)},
                                   {"size", size_text(part->bounds)},
                                   {"facets", part->mesh.facets.size()},
                                   {"warnings", part->warnings},
                                   {"notes", notes}};
    if (const auto odd = unit_warning(part->bounds, *job)) json["warnings"].push_back(*odd);
    std::cout << json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) << "\n";
    return kExitDone;
  }
  for (const std::string& note : notes) std::cout << note << "\n";
  std::cout << size_text(part->bounds) << ", " << part->mesh.facets.size() << " facets\n";
  for (const std::string& warning : part->warnings) std::cout << "warning: " << warning << "\n";
  if (const auto odd = unit_warning(part->bounds, *job)) std::cout << "warning: " << *odd << "\n";
  return kExitDone;
}

/// The exit status.
int run(int argc, char** argv) {
  hear_interrupts();
  CLI::App app{
      "Tiltfeed: from an STL part to a 5-axis machine with a rotary table and a tilting head.\n"
      "Not a safety device: emergency stop and guards belong to the machine."};
  app.set_version_flag("--version", "tiltfeed " + config::version());
  app.require_subcommand(1);

  std::string check_job;
  CLI::App* check =
      app.add_subcommand("check", "read a job, its machine profile and its part, print them resolved");
  check->add_option("JOB", check_job, "job file (YAML)")->required();
  bool check_json = false;
  check->add_flag("--json", check_json, "print one JSON object");

  // Its options are those of `tiltfeed-sim verify`, which takes them as they are.
  CLI::App* verify =
      app.add_subcommand("verify", "cut the stock by a program or a trace and compare with the part");
  verify->prefix_command()->set_help_flag();
  CLI::App* desk =
      app.add_subcommand("desk", "the page in a browser on this computer: a part, its job, its program");
  desk->prefix_command()->set_help_flag();

  PlanFiles files;
  std::string progress;
  CLI::App* planning = app.add_subcommand("plan", "plan the tool path and write the machine's program");
  planning->add_option("JOB", files.job, "job file (YAML)")->required();
  planning->add_option("--operation", files.operation,
                       "plan this operation of the job alone; default: all, in one program");
  bool each = false;
  planning
      ->add_flag(
          "--each", each,
          "a program for each operation: its name goes before the ending of --out, --cl, --report, --map")
      ->excludes("--operation");
  planning->add_option("--out", files.program, "program to write (G-code)")->required();
  planning->add_option("--cl", files.cl, "cutter location file to write (APT text)");
  planning->add_option("--report", files.report, "report to write (JSON)");
  planning->add_option("--map", files.map, "map to write: from each motion block to its move and STL facet");
  planning->add_option(
      "--drawing", files.drawing,
      "tool poses and times of all blocks to write, for a viewer: float32, see daemon/plan/README.md");
  planning->add_option("--stl", files.stl, "take this part instead of the job's");
  planning->add_option("--machine", files.machine, "take this machine profile instead of the job's");
  std::string optimise;
  planning
      ->add_option("--optimise", optimise,
                   "time: take the direction and the distances of passes that are quickest and leave no more "
                   "than the job's own; feed: let "
                   "the feed of cuts follow what the cutter has to cut, within the job's feeds and the "
                   "largest load at "
                   "its own")
      ->check(CLI::IsMember({"time", "feed"}));
  planning->add_option(
      "--stock", files.stock,
      "with --optimise feed: offset:MM, box, box:MM, cylinder, cylinder:MM or an STL file; default: "
      "what the job's rapids allow for");
  planning->add_flag("!--no-proof", files.prove,
                     "do not hold the printed moves against the part; the program's header says so");
  planning->add_option("--progress", progress, "file that holds stage and percentage while it plans");
  planning->add_flag(
      "--alone", files.alone,
      "as a service plans: only job and part are there; another file that the job names is refused");
  planning->add_flag("--closed", files.closed,
                     "as a service plans for another machine: no file is read but job, part and profile");
  planning->add_flag("--json", files.as_json, "print the report (JSON) instead of its summary");
  planning->add_option("--gouge-picture", files.gouge_picture,
                       "picture (PNG) of the deepest gouge where the program is refused");

  std::string program, link, send_machine;
  CLI::App* send = app.add_subcommand("send", "stream a program to the controller");
  send->add_option("PROGRAM", program, "program to send (G-code)")->required();
  send->add_option(
      "--link", link,
      "grbl:/dev/ttyUSB0@115200, grbl-tcp:HOST:PORT, grbl-ws:HOST:PORT[/PATH], reprap:/dev/ttyACM0@250000, "
      "dnc:/dev/ttyS0@9600, "
      "modbus-tcp:HOST:PORT, modbus-rtu:/dev/ttyS0@19200, drive-tcp:HOST:PORT, drive-rtu:/dev/ttyS0@19200; "
      "else the profile's link.default");
  send->add_option("--machine", send_machine, "machine profile (YAML): its default link and its wire");

  bool send_json = false;
  send->add_flag("--json", send_json, "print what was sent as one JSON object");
  double tool_length = 0.0;
  send->add_option("--tool-length", tool_length,
                   "gauge line to tip of the tool in the spindle, mm; a program for another is refused")
      ->check(above_zero);

  const PostCommands posting(app);
  const MachineCommands machines(app);
  const MeasureCommand measuring(*app.get_subcommand("machine"));
  const SuggestCommand suggesting(app);
  const InitCommand beginning(app);
  const ToolsCommand tools(app);
  ServiceCommands service(app, config::version());
  const ShopCommand shop(app);
  const ToolCommand tool_change(app);
  const DoctorCommand doctor(app, config::version());
  const MetricsCommand metrics(app, config::version());
  const MtconnectCommand mtconnect(app, config::version());
  const HistoryCommand history(app);
  const SupportCommand support(app, config::version());
  const ManualCommand manual(app, config::version());
  if (argc == 2 && std::string_view(argv[1]) == config::kDescribeWord)
    return show_json(config::command_json(config::describe_command_line(app, "tiltfeed")));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return config::report_parse_end(app, error) ? kExitDone : kExitWrongUse;
  }
  if (verify->parsed()) return complain(hand_over("tiltfeed-sim", {"verify"}, verify->remaining()));
  if (desk->parsed()) return complain(hand_over("tiltfeed-desk", {}, desk->remaining()));
  if (const std::optional<int> status = service.run()) return *status;
  if (shop.called()) return shop.run();
  if (tool_change.called()) return tool_change.run();
  if (send->parsed()) {
    if (send->count("--tool-length") > 0)
      if (auto same = check_tool_length(program, tool_length); !same) return complain(same.error());
    return send_command(program, link, send_machine, send_json);
  }
  if (metrics.called()) return metrics.run();
  if (mtconnect.called()) return mtconnect.run();
  if (history.called()) return history.run();
  if (support.called()) return support.run();
  if (manual.called()) return manual.run();
  if (doctor.called()) return doctor.run();
  if (machines.at_machine()) return machines.run();
  const PromptEnd prompt_end;  // what touches no machine may end at any place
  if (check->parsed()) return check_command(check_job, check_json);
  if (suggesting.called()) return suggesting.run();
  if (beginning.called()) return beginning.run();
  if (measuring.called()) return measuring.run();
  if (tools.called()) return tools.run();
  files.shortest_time = optimise == "time", files.engaged_feeds = optimise == "feed";
  if (planning->parsed()) return plan_command(files, each, progress);
  return posting.called() ? posting.run() : machines.run();
}

}  // namespace

int main(int argc, char** argv) {
  config::open_standard_streams();
  return config::close_standard_output("tiltfeed", run(argc, argv));
}
