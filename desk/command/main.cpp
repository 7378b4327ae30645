// The program `tiltfeed-desk`: the page's server, and the processes that read for it.

#include <fcntl.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>

#include "config/beside_program.h"
#include "config/command_line.h"
#include "config/desk_access.h"
#include "config/key_names.h"
#include "config/queue_key.h"
#include "config/service_config.h"
#include "config/standard_output.h"
#include "config/version.h"
#include "config/yaml_tree.h"
#include "desk/api/desk.h"
#include "desk/command/token_command.h"
#include "desk/command/user_command.h"
#include "desk/http/http_server.h"
#include "desk/reach/reach_answers.h"
#include "desk/view/part_view.h"
#include "desk/webhooks/webhooks.h"
#include "desk/work/child_process.h"
#include "desk/work/scratch_folder.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::desk;

constexpr const char *kUser = "user", *kToken = "token";  // commands; any other word is a file

int complain(const Error& error) {
  std::cerr << "tiltfeed-desk: " << error.message << "\n";
  return error.code == Code::kUsage ? 2 : 1;
}

/// SIGINT and SIGTERM as a descriptor, beside a service SIGHUP, too; SIGPIPE and SIGTTIN are no reason to end
/// or stop.
int open_signals(bool beside) {
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGTTIN, SIG_IGN);  // in the background of a shell, the terminal is not ours to read
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  if (beside) sigaddset(&ends, SIGHUP);
  ::sigprocmask(SIG_BLOCK, &ends, nullptr);
  return ::signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK);
}

Result<void> print_address(Desk& desk) {
  const Result<std::string> address = desk.new_address();
  if (!address) return tl::unexpected<Error>(address.error());
  std::cout << *address << std::endl;
  return {};
}

/// A line on the standard input asks for a new address. False: nothing more comes from there.
bool hear_input(Desk& desk) {
  std::array<char, 256> typed{};
  const ssize_t count = ::read(STDIN_FILENO, typed.data(), typed.size());
  if (count <= 0) return false;
  if (std::memchr(typed.data(), '\n', static_cast<std::size_t>(count))) (void)print_address(desk);
  return true;
}

/// A new address is wanted (SIGHUP), or the end.
bool goes_on(Desk& desk, int signals) {
  signalfd_siginfo info{};
  if (::read(signals, &info, sizeof info) != sizeof info) return true;
  if (info.ssi_signo != SIGHUP) return false;
  (void)print_address(desk);
  return true;
}

/// Until a signal ends it.
int serve(Desk& desk, HttpServer& server, int signals) {
  bool input = true;
  while (true) {
    std::vector<pollfd> polled{{signals, POLLIN, 0}, {server.descriptor(), POLLIN, 0}};
    polled.push_back({input ? STDIN_FILENO : -1, POLLIN, 0});
    for (const int fd : desk.descriptors()) polled.push_back({fd, POLLIN, 0});
    const int own = desk.patience_ms(), wait = server.patience_ms();
    if (::poll(polled.data(), polled.size(), own < 0 || (wait >= 0 && wait < own) ? wait : own) < 0 &&
        errno != EINTR)
      return complain({Code::kIo, std::string("poll: ") + std::strerror(errno)});
    if (polled[0].revents != 0 && !goes_on(desk, signals)) return 0;
    if (polled[2].revents != 0) input = hear_input(desk);
    for (std::size_t i = 3; i < polled.size(); ++i)
      if (polled[i].revents != 0) desk.hear(polled[i].fd);
    desk.look();
    server.turn();
  }
}

/// The service's usual socket, where there is one.
std::string usual_service() {
  const char* const set = std::getenv("TILTFEED_SOCKET");
  const std::string socket = set ? set : "/run/tiltfeed/api.sock";
  return ::access(socket.c_str(), F_OK) == 0 ? socket : "";
}

struct Beside {
  std::string service, machine;
  bool by_file = false;  // named by the service's file, as a unit does
  std::string queue;     // of that file
  std::string shop;      // the queue that is shown; empty: none
  std::string file;      // the service's; empty: not known
};

/// The queue that --shop shows.
Result<std::string> shop_queue(const std::string& stated, const config::DeskAccess& access,
                               const Beside& beside) {
  const char* const named = std::getenv("TILTFEED_SHOP");
  std::string url = !stated.empty() ? stated : !access.queue.empty() ? access.queue : beside.queue;
  if (url.empty() && named != nullptr) url = named;
  if (url.empty())
    return fail(
        Code::kUsage,
        "--shop: no queue is named; write its address behind --shop, or `queue` into the file of --access "
        "or of --beside, or set TILTFEED_SHOP");
  if (const Result<void> good = config::check_queue_url(url); !good)
    return fail(Code::kUsage, "the shop's queue: " + good.error().message);
  return url;
}

/// Where it listens, and its certificate.
Result<HttpOptions> http_options(const config::DeskAccess& access, const std::string& folder) {
  HttpOptions options{static_cast<std::uint16_t>(access.port), folder, access.address};
  options.behind_proxy = access.behind_proxy;
  if (access.certificate.empty()) return options;
  const Result<std::string> certificate = config::read_config_text(access.certificate),
                            key = config::read_config_text(access.key);
  if (!certificate || !key) return tl::unexpected<Error>(certificate ? key.error() : certificate.error());
  options.certificate = *certificate;
  options.key = *key;
  return options;
}

/// Nothing where the access file names none.
Result<std::unique_ptr<Webhooks>> start_webhooks(const config::DeskAccess& access,
                                                 const std::string& socket) {
  if (access.webhooks.empty()) return nullptr;
  return Webhooks::start({access.webhooks, access.state, socket},
                         [](const std::string& text) { std::cerr << "tiltfeed-desk: " + text + "\n"; });
}

int run_desk(const std::string& open, const config::DeskAccess& access, const Beside& beside) {
  const Result<std::string> self = config::program_beside("tiltfeed-desk"),
                            planner = config::program_beside("tiltfeed"),
                            maker = config::program_beside("tiltfeed-sim");
  if (!self || !planner || !maker) return complain(self ? planner.error() : self.error());
  Result<ScratchFolder> folder = ScratchFolder::make();
  if (!folder) return complain(folder.error());
  const int signals = open_signals(beside.by_file);
  HttpServer* teller = nullptr;
  Desk desk(
      {*self, *planner, *maker, folder->path(), config::version(), beside.service, beside.machine,
       access.names, access.is_https(), access.users, access.tokens, beside.shop, beside.file},
      [&](const std::string& event, const std::string& data) {
        if (teller) teller->tell(event, data);
      },
      [&](std::uint64_t ticket, const Reply& reply) {
        if (teller) teller->finish(ticket, reply);
      });
  const Result<HttpOptions> http = http_options(access, folder->path());
  if (!http) return complain(http.error());
  Result<HttpServer> server =
      HttpServer::open(*http, {[&](const Request& r, BodyRule& rule) { return desk.admit(r, rule); },
                               [&](const Request& r) { return desk.answer(r); }});
  if (!server) return complain(server.error());
  teller = &*server;
  desk.set_port(server->port());
  if (!open.empty())
    if (const Result<void> opened = desk.open(open); !opened) return complain(opened.error());
  const Result<std::unique_ptr<Webhooks>> webhooks = start_webhooks(access, beside.service);
  if (!webhooks) return complain(webhooks.error());
  if (const Result<void> printed = print_address(desk); !printed) return complain(printed.error());
  if (::isatty(STDIN_FILENO) == 1)
    std::cerr << "Open this address in a browser on this computer. It signs one browser in, once.\n"
                 "Enter: a new address. Ctrl-C: the end.\n";
  return serve(desk, *server, signals);
}

/// `tiltfeed-desk user ...` and `... token ...`: before the options of the page, which takes any other word
/// for a file.
struct NamesLine {
  CLI::App app;
  std::string file, name, role;
  CLI::App *add = nullptr, *remove = nullptr, *list = nullptr;

  /// `what`: who has a name; `roles`: option, its help and its values.
  NamesLine(const char* about, const std::string& word, const std::string& usual, const std::string& what,
            const char* role_option, const char* role_help, const std::vector<std::string>& roles)
      : app(about, "tiltfeed desk " + word), file(usual) {
    app.require_subcommand(1);
    add = app.add_subcommand("add", "a " + what);
    remove = app.add_subcommand("remove", "who may not come in any more");
    list = app.add_subcommand("list", "names, and what they may do");
    for (CLI::App* const command : {add, remove, list})
      command->add_option("--" + word + "s", file, "the file")->capture_default_str();
    for (CLI::App* const command : {add, remove}) command->add_option("NAME", name)->required();
    add->add_option(role_option, role, role_help)->required()->check(CLI::IsMember(roles));
  }
};

struct UserLine : NamesLine {
  UserLine()
      : NamesLine("Who may sign in where the page is served on a network.", kUser, "/etc/tiltfeed/desk.users",
                  "user, or a new password and role for one that is there", "--role",
                  "watch, or operate the machine", {"watch", "operate"}) {}
};

struct TokenLine : NamesLine {
  TokenLine()
      : NamesLine("Which programs may use the API, by a token in place of a password.", kToken,
                  "/etc/tiltfeed/desk.tokens",
                  "program, or a new token and scope for one that is there: the token is printed this once",
                  "--scope", "watch, or submit parts, jobs and programs too", {"watch", "submit"}) {}
};

int print_or_complain(const Result<std::string>& text) {
  if (!text) return complain(text.error());
  std::cout << *text;
  return 0;
}

int run_users(const UserLine& line) {
  if (line.list->parsed()) return print_or_complain(list_users(line.file));
  const Result<void> done =
      line.add->parsed() ? add_user(line.file, line.name, line.role) : remove_user(line.file, line.name);
  return done ? 0 : complain(done.error());
}

int run_tokens(const TokenLine& line) {
  if (line.list->parsed()) return print_or_complain(list_tokens(line.file));
  if (line.add->parsed()) {
    Result<std::string> token = add_token(line.file, line.name, line.role);
    if (token) *token += "\n";
    return print_or_complain(token);
  }
  const Result<void> done = remove_token(line.file, line.name);
  return done ? 0 : complain(done.error());
}

template <class Line>
int run_names(int argc, char** argv, int (*run)(const Line&)) {
  Line line;
  try {
    line.app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return config::report_parse_end(line.app, error) ? 0 : 2;
  }
  return run(line);
}

/// A word for a command, misspelt, stands where a file is named: no file has this name, nor a file's ending.
bool is_misspelt_command(const std::string& word) {
  return !word.empty() && word.find_first_of("./-") == word.npos && ::access(word.c_str(), F_OK) != 0;
}

int refuse_command(const std::string& word) {
  std::cerr << "tiltfeed-desk: not understood: " << word << ", and no file has this name; the nearest is "
            << config::nearest_key(word, {kUser, kToken}) << "\nRun with --help for more information.\n";
  return 2;
}

int run(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == kUser) return run_names<UserLine>(argc - 1, argv + 1, run_users);
  if (first == kToken) return run_names<TokenLine>(argc - 1, argv + 1, run_tokens);
  if (is_misspelt_command(first)) return refuse_command(first);
  CLI::App app{
      "The page for one person at this computer: a part, its job, its program.\n"
      "It listens on this computer only, and prints the address to open."};
  app.set_version_flag("--version", "tiltfeed-desk " + config::version());
  std::string open, into;
  PartAsked view;
  app.add_option(
      "FILE", open,
      "the job (.yaml) with its part, or the part (STL, OBJ, PLY, 3MF, STEP, IGES), to begin with");
  config::DeskAccess access;
  std::string access_file;
  app.add_option("--access", access_file,
                 "where it is served on a network, and to whom (YAML: config/desk.yaml)");
  app.add_option("--port", access.port, "port to listen on; else a free one");
  std::string shop_url;
  const CLI::Option* const shop =
      app.add_option(
             "--shop", shop_url,
             "a page of all machines and jobs of the shop's queue, postgresql://USER@HOST/DATABASE; where "
             "no address follows: `queue` of --access, else of --beside, else $TILTFEED_SHOP")
          ->expected(0, 1);
  Beside beside{usual_service(), "", false, "", "", ""};
  app.add_option("--service", beside.service,
                 "socket of tiltfeed serve, for the machine (default: $TILTFEED_SOCKET, else "
                 "/run/tiltfeed/api.sock, where it is there)");
  std::string service_file;
  app.add_option("--beside", service_file, "the file of that service (YAML): its socket and its machine");
  app.add_option("--machine", beside.machine,
                 "profile of that machine (YAML): shows the tool on the parts of jobs planned elsewhere");
  app.add_option("--view-part", view.path)->group("");
  app.add_option("--unit", view.unit)->group("");
  app.add_option("--into", into)->group("");
  app.add_option("--body", view.bodies)->group("");
  app.add_option("--avoid", view.avoid)->group("");
  app.add_option("--deviation", view.deviation)->group("");
  bool answer = false;
  app.add_flag("--answer-reach", answer)->group("");
  if (argc == 2 && std::string_view(argv[1]) == config::kDescribeWord) {
    config::Command all = config::describe_command_line(app, "tiltfeed-desk");
    all.commands.push_back(config::describe_command_line(UserLine().app, kUser));
    all.commands.push_back(config::describe_command_line(TokenLine().app, kToken));
    std::cout << config::command_json(all) << "\n";
    return 0;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return config::report_parse_end(app, error) ? 0 : 2;
  }
  if (is_misspelt_command(open)) return refuse_command(open);
  if (answer) return answer_reach();
  if (!access_file.empty()) {
    const Result<config::DeskAccess> loaded = config::load_desk_access(access_file);
    if (!loaded) return complain(loaded.error());
    access = *loaded;
  }
  if (!service_file.empty()) {
    const Result<config::ServiceConfig> service = config::load_service_config(service_file);
    if (!service) return complain(service.error());
    beside = {service->socket, service->machine.path, true, service->queue.url, "", service_file};
  }
  if (shop->count() > 0) {
    const Result<std::string> queue = shop_queue(shop_url, access, beside);
    if (!queue) return complain(queue.error());
    beside.shop = *queue;
  }
  if (view.path.empty()) return run_desk(open, access, beside);
  const Result<void> written = write_part_view(view, into);
  return written ? 0 : complain(written.error());
}

}  // namespace

int main(int argc, char** argv) {
  config::open_standard_streams();
  return config::close_standard_output("tiltfeed-desk", run(argc, argv));
}
