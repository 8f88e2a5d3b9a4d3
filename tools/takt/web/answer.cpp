#include "web/answer.hpp"

#include <takt/model/json.hpp>

namespace takt::tool::web {

Answer answer_of(const Json& json) { return {200, model::json_text(json)}; }

Answer answer_of(int status, const Problem& problem) {
  const std::string where = problem.where.empty() ? "" : problem.where + ": ";
  return {status, model::json_text({{"what", where + problem.what}, {"fix", problem.fix}})};
}

}  // namespace takt::tool::web
