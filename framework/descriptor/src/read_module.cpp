#include "read_module.hpp"

#include <algorithm>
#include <limits>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>
#include "element.hpp"

namespace takt::descriptor {

namespace {

using model::Operation;
using std::chrono::milliseconds;

constexpr Nanoseconds kStandIn = milliseconds{1};  // used in place of a time that could not be read

const Shape kModule{.once = {"name", "filename", "moduletype", "operationtype", "period", "offset",
                             "deadline", "dispatch", "interarrival", "priority", "executor", "budget",
                             "overrun", "recovery", "retain", "arguments", "property", "safe"}};
const Shape kBudget{.attributes = {"times", "in-a-row", "hang"}, .text = true};
const Shape kOverrun{.attributes = {"limit"}, .text = true};
const Shape kDeadline{.attributes = {"miss"}, .text = true};
const Shape kRecovery{.attributes = {"attempts", "backoff", "then"}};
const Shape kArguments{.many = {"argument"}};
const Shape kArgument{.text = true};
const Shape kProperty{.many = {"value"},
                      .hint = R"(write <property><value name="NAME">VALUE</value></property>)"};
const Shape kValue{.attributes = {"name"}, .text = true};
const Shape kSafe{.many = {"port"}};
const Shape kPort{.attributes = {"name"}, .many = {"field"}};
const Shape kField{.attributes = {"name"}, .text = true};

class ModuleReader {
 public:
  ModuleReader(const Node& xml, Report& report) : element_(xml, kModule, report), report_(report) {}

  ModuleReading read(const std::vector<model::Executor>& executors) {
    module_.line = element_.line();
    read_kind();
    read_name();
    read_times();
    read_priority();
    read_executor(executors);
    read_recovery();
    read_retain();
    read_arguments();
    read_properties();
    read_safe();
    return {std::move(module_), name_known_};
  }

 private:
  /// Returns the text of a child that every module must have. Reports the child if it is missing.
  std::optional<Given> required(const char* name, const std::string& fix) {
    std::optional<Given> given = element_.child_text(name);
    if (!given && !element_.was_meant(name)) {
      report_.add(element_.line(), std::string{"a module has no <"} + name + ">", fix);
    }
    return given;
  }

  void read_kind() {
    if (const auto given = required(
            "moduletype", "write <moduletype>thread</moduletype> for a .so, or process for a program")) {
      const auto choice = read_choice(*given, {"thread", "process"}, report_);
      if (choice) module_.type = *choice == 0 ? model::ModuleType::thread : model::ModuleType::process;
    }
    if (const auto given = required(
            "operationtype", "write <operationtype>periodic</operationtype>, or sporadic or non-real")) {
      const auto choice = read_choice(*given, {"periodic", "sporadic", "non-real"}, report_);
      if (choice) {
        constexpr Operation kOperations[] = {Operation::periodic, Operation::sporadic, Operation::non_real};
        module_.operation = kOperations[*choice];
        operation_known_ = true;
      }
    }
  }

  void read_name() {
    const auto filename =
        required("filename", "name its .so or program, as in <filename>servo.so</filename>");
    const bool filename_known = filename && !filename->unread;
    module_.filename = filename_known ? filename->trimmed() : "unread";
    if (filename) module_.lines.filename = filename->line;

    if (const auto name = element_.child_text("name")) {
      name_known_ = !name->unread;
      module_.name = name->trimmed();
      module_.lines.name = name->line;
    } else {
      name_known_ = filename_known && !element_.was_meant("name");
      module_.name = model::file_stem(module_.filename);
    }
  }

  std::optional<Nanoseconds> child_time(const char* name, model::Line& line, Nanoseconds least) {
    const auto given = element_.child_text(name);
    return given ? std::optional{time_of(*given, line, least)} : std::nullopt;
  }

  Nanoseconds time_of(const Given& given, model::Line& line, Nanoseconds least = Nanoseconds{1}) {
    line = given.line;
    return read_time(given, {.from = least}, report_).value_or(kStandIn);
  }

  void read_offset() {
    const auto given = element_.child_text("offset");
    if (!given) return;
    module_.lines.offset = given->line;
    module_.offset = read_time(*given, {}, report_).value_or(Nanoseconds{0});
  }

  void read_budget() {
    const auto* xml = element_.child("budget");
    if (xml == nullptr) return;
    const Element budget{*xml, kBudget, report_};
    module_.budget = time_of(budget.given_text(), module_.lines.budget);
    const auto read = [&](const char* name) -> std::optional<int> {
      const auto given = budget.attribute(name);
      if (!given) return std::nullopt;
      return static_cast<int>(read_number(*given, {1, model::kMaxTolerance}, report_).value_or(1));
    };
    module_.tolerance = {.times = read("times"), .in_a_row = read("in-a-row")};
    if (const auto given = budget.attribute("hang")) {
      if (const auto hang = read_time(*given, {.from = Nanoseconds{1}}, report_)) module_.hang = hang;
    }
  }

  void read_overrun() {
    const auto* xml = element_.child("overrun");
    if (xml == nullptr) return;
    const Element overrun{*xml, kOverrun, report_};
    module_.lines.overrun = overrun.line();
    module_.overrun = read_contract(overrun.given_text(), overrun.attribute("limit"), report_);
  }

  void read_deadline() {
    const auto* xml = element_.child("deadline");
    if (xml == nullptr) return;
    const Element deadline{*xml, kDeadline, report_};
    module_.deadline = time_of(deadline.given_text(), module_.lines.deadline);
    if (const auto given = deadline.attribute("miss")) {
      if (read_choice(*given, {"count", "error"}, report_) == 1U) module_.miss = model::Miss::error;
    }
  }

  void read_dispatch() {
    const auto given = element_.child_text("dispatch");
    if (!given) return;
    module_.lines.dispatch = given->line;
    if (read_choice(*given, {"row", "immediate"}, report_) == 1U)
      module_.dispatch = model::Dispatch::immediate;
  }

  void read_retain() {
    const auto given = element_.child_text("retain");
    if (!given) return;
    module_.lines.retain = given->line;
    module_.retain = read_choice(*given, {"false", "true"}, report_) == 1U;
  }

  void read_times() {
    module_.period = child_time("period", module_.lines.period, model::kMinPeriod);
    read_deadline();
    read_dispatch();
    module_.interarrival = child_time("interarrival", module_.lines.interarrival, Nanoseconds{1});
    read_offset();
    read_budget();
    read_overrun();
    if (!operation_known_) {
      // If the operation type could not be read, it is not known which times the module may have. Continue as
      // if the module were non-real, because a non-real module needs no times.
      module_.operation = Operation::non_real;
      module_.period.reset();
      module_.deadline.reset();
      module_.miss = model::Miss::count;
      module_.dispatch = model::Dispatch::row;
      module_.lines.dispatch = {};
      module_.interarrival.reset();
      module_.budget.reset();
      module_.tolerance = {};
      module_.offset.reset();
      module_.overrun.reset();
    } else if (module_.operation == Operation::periodic && !module_.period && element_.was_meant("period")) {
      module_.period = kStandIn;
    } else if (module_.operation == Operation::sporadic && !module_.deadline &&
               element_.was_meant("deadline")) {
      module_.deadline = kStandIn;
    }
  }

  void read_priority() {
    using Limits = std::numeric_limits<int>;
    if (const auto given = element_.child_text("priority")) {
      const auto number = read_number(*given, {Limits::min(), Limits::max()}, report_);
      if (number) module_.priority = static_cast<int>(*number);
    } else if (module_.operation != Operation::non_real && !element_.was_meant("priority")) {
      report_.add(module_.line,
                  std::string{to_text(module_.operation)} + " module " + in_quotes(module_.name) +
                      " has no <priority>",
                  "add one: a whole number; the lowest number is the highest priority");
    }
  }

  void read_executor(const std::vector<model::Executor>& executors) {
    const auto given = element_.child_text("executor");
    if (!operation_known_) return;
    if (given) {
      module_.executor = given->unread ? "" : given->trimmed();
      module_.lines.executor = given->line;
      if (!module_.executor.empty()) return;
      if (!given->unread)
        report_.add(given->line, given->what + " is empty",
                    "name an executor of the device, or remove the element");
    }
    const bool stands_in = given || element_.was_meant("executor");
    const bool scheduled = module_.operation != Operation::non_real;
    if (scheduled && (stands_in || executors.size() == 1)) module_.executor = executors.front().name;
  }

  void read_recovery() {
    const auto* xml = element_.child("recovery");
    if (xml == nullptr) return;
    const Element element{*xml, kRecovery, report_};
    model::Recovery& recovery = module_.recovery;
    if (const auto given = element.attribute("attempts")) {
      const auto number = read_number(*given, {0, model::kMaxAttempts}, report_);
      if (number) recovery.attempts = static_cast<int>(*number);
    }
    if (const auto given = element.attribute("backoff")) {
      const auto backoff = read_time(*given, {.to = model::kMaxBackoff}, report_);
      if (backoff) recovery.backoff = *backoff;
    }
    if (const auto given = element.attribute("then")) {
      const auto choice = read_choice(*given, {"destruct", "stop-device", "stop-cell"}, report_);
      constexpr model::GiveUp kThen[] = {model::GiveUp::destruct, model::GiveUp::stop_device,
                                         model::GiveUp::stop_cell};
      if (choice) recovery.then = kThen[*choice];
    }
  }

  void read_arguments() {
    const auto* xml = element_.child("arguments");
    if (xml == nullptr) return;
    const Element arguments{*xml, kArguments, report_};
    module_.lines.arguments = arguments.line();
    for (const auto* child : arguments.children("argument")) {
      if (report_.full()) break;
      module_.arguments.push_back(Element{*child, kArgument, report_}.text());
    }
  }

  void read_properties() {
    const auto* xml = element_.child("property");
    if (xml == nullptr) return;
    const Element property{*xml, kProperty, report_};
    for (const auto* child : property.children("value")) {
      if (report_.full()) break;
      const Element value{*child, kValue, report_};
      const auto name = value.required_attribute("name");
      if (name) module_.properties.push_back({name->trimmed(), value.text(), value.line()});
    }
  }

  void read_safe() {
    const auto* xml = element_.child("safe");
    if (xml == nullptr) return;
    const Element safe{*xml, kSafe, report_};
    for (const auto* child : safe.children("port")) {
      if (report_.full()) break;
      const Element port{*child, kPort, report_};
      const auto name = port.required_attribute("name");
      model::SafeValue value{.name = name ? name->trimmed() : "", .fields = {}, .line = port.line()};
      for (const auto* given : port.children("field")) {
        const Element field{*given, kField, report_};
        const auto of = field.required_attribute("name");
        if (of) value.fields.push_back({of->trimmed(), field.given_text().trimmed(), field.line()});
      }
      if (name) module_.safe.push_back(std::move(value));
    }
  }

  Element element_;
  Report& report_;
  model::Module module_;
  bool operation_known_ = false;
  bool name_known_ = true;
};

}  // namespace

ModuleReading read_module(const Node& xml, const std::vector<model::Executor>& executors, Report& report) {
  return ModuleReader{xml, report}.read(executors);
}

bool is_of_module(std::string_view name) {
  return std::find(kModule.once.begin(), kModule.once.end(), name) != kModule.once.end();
}

}  // namespace takt::descriptor
