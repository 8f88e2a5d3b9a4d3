// Problems as JSON: in replies, and between a node and the process that inspects its components.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>

namespace takt::agent {

/// Returns the problems as a JSON list: [{"where", "what", "fix"}, ...].
inline nlohmann::ordered_json problems_json(const Problems& problems) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Problem& problem : problems)
    list.push_back({{"where", problem.where}, {"what", problem.what}, {"fix", problem.fix}});
  return list;
}

inline Problems problems_from(const nlohmann::ordered_json& list) {
  Problems problems;
  for (const auto& entry : list)
    problems.push_back({entry.value("where", ""), entry.value("what", ""), entry.value("fix", "")});
  if (problems.empty()) problems.push_back(fail("no reason was given"));
  return problems;
}

}  // namespace takt::agent
