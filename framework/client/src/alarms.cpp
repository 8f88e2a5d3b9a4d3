#include <takt/client/alarms.hpp>

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/user.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include "reports.hpp"

namespace takt::client {

Result<std::vector<model::Alarm>> alarms_in(const std::string& device, const std::string& data) {
  std::vector<model::Alarm> alarms;
  const auto read = read_answer(device, data, [&](const nlohmann::ordered_json& value) {
    auto list = model::alarms_from(value);
    if (!list) throw std::invalid_argument{"no alarms"};
    alarms = std::move(*list);
  });
  if (!read) return read.problems();
  for (model::Alarm& alarm : alarms) {
    for (std::string* text : {&alarm.device, &alarm.module, &alarm.error, &alarm.cause})
      *text = on_one_line(*text);
    if (auto& said = alarm.acknowledged)
      *said = {on_one_line(said->by), on_one_line(said->note), said->time_ns};
  }
  return alarms;
}

AllAlarms read_alarms(Operator& sender, const std::string& device) {
  AllAlarms all;
  std::set<std::string> names{device};
  if (device.empty()) {
    const auto reports = all_reports(sender);
    if (!reports) return {.alarms = {}, .problems = reports.problems()};
    all.problems = reports->problems;
    names = reports->named;
    for (const auto& [node, report] : reports->nodes) names.insert(report.at("name").get<std::string>());
    for (const auto& [name, known] : reports->lost) {
      if (!reports->answered(name) && names.erase(name) != 0) all.problems.push_back(sender.lost(name));
    }
  }
  std::vector<CommandRequest> requests;
  for (const std::string& name : names) requests.push_back({.kind = COMMAND_ALARMS, .device = name});
  auto answers = sender.send(requests);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    const auto alarms = answer ? alarms_in(requests[i].device, answer->data) : answer.problems();
    if (!alarms) {
      for (const Problem& problem : alarms.problems()) {
        if (std::ranges::find(all.problems, problem) == all.problems.end()) all.problems.push_back(problem);
      }
      continue;
    }
    std::ranges::copy(*alarms, std::back_inserter(all.alarms));
  }
  std::ranges::stable_sort(all.alarms, model::is_worse);
  return all;
}

Result<std::vector<model::Alarm>> acknowledge(Operator& sender, const std::string& device,
                                              const std::string& module, const std::string& note,
                                              std::uint64_t number) {
  const model::Acknowledge data{.note = note, .alarm = number};
  const std::string text = model::json_text(model::to_json(data));
  // The node says the same, but not before the device is found.
  if (const auto valid = model::acknowledge_from(text); !valid) return valid.problems();
  const auto answer = accepted(sender.send({.kind = COMMAND_ACKNOWLEDGE,
                                            .device = device,
                                            .module = module,
                                            .value = user_at_machine(),
                                            .data = text}));
  if (!answer) return answer.problems();
  return alarms_in(device, answer->data);
}

}  // namespace takt::client
