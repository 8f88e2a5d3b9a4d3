// A process module with a service. It forwards each request to another service, and answers with the reply of
// that service.
#include <takt/process.hpp>

#include "sample.hpp"

int main() {
  takt::Service<samples::Count, samples::Count> pass{"pass"};
  takt::Client<samples::Count, samples::Count> ask{"ask"};
  initPeriodExe();
  while (true) {
    waitPeriod();
    switch (ask.poll()) {
      case takt::CallStatus::pending:
        break;
      case takt::CallStatus::replied:
        pass.reply(ask.reply());
        break;
      case takt::CallStatus::refused:
        pass.refuse(ask.reason());
        break;
      case takt::CallStatus::timed_out:
      case takt::CallStatus::nobody:
        pass.refuse(to_text(ask.status()));
        break;
      case takt::CallStatus::idle:
        break;
    }
    if (ask.status() != takt::CallStatus::pending && pass.take())
      ask.call(pass.request(), std::chrono::milliseconds{200});
  }
}
