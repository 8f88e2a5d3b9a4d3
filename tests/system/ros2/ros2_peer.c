/* Looks like a ROS 2 node on the network: topics under rt/, ROS 2 type names, the default quality of service of ROS 2 (reliable,
 * volatile, history of ten). The program uses nothing of Takt.
 *
 *   ros2_peer DOMAIN pub TYPE TOPIC COUNT PERIOD_MS [best-effort]
 *   ros2_peer DOMAIN sub TYPE TOPIC COUNT SECONDS        until COUNT samples have arrived; prints one JSON object a line
 *   ros2_peer DOMAIN list SECONDS                        the writers and readers of other participants: "pub|sub TOPIC TYPE RELIABILITY"
 *
 * TYPE: Float64, String, JointState, Twist. TOPIC as in ROS 2: /chatter. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "dds/dds.h"
#include "ros2.h"

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static dds_entity_t must(dds_entity_t entity, const char *what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "%s: %s\n", what, dds_strretcode(-entity));
  exit(3);
}

/* Returns the QoS of rmw_qos_profile_default; with best_effort, its reliability is best-effort, as in rmw_qos_profile_sensor_data. */
static dds_qos_t *profile(int best_effort) {
  dds_qos_t *qos = dds_create_qos();
  dds_qset_reliability(qos, best_effort ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  return qos;
}

static void print_number(const void *sample) { printf("{\"data\": %.17g}\n", ((const std_msgs_msg_dds__Float64_ *)sample)->data); }
static void fill_number(void *sample, int n) { ((std_msgs_msg_dds__Float64_ *)sample)->data = 0.5 * n; }

static void print_text(const void *sample) { printf("{\"data\": \"%s\"}\n", ((const std_msgs_msg_dds__String_ *)sample)->data); }
static void fill_text(void *sample, int n) {
  static char text[400];
  /* The third text is longer than the port allows. */
  if (n == 3) {
    memset(text, 'x', 300);
    text[300] = '\0';
  } else {
    snprintf(text, sizeof text, "hello %d", n);
  }
  ((std_msgs_msg_dds__String_ *)sample)->data = text;
}

static void print_list(const char *name, const double *values, uint32_t length) {
  printf(", \"%s\": [", name);
  for (uint32_t i = 0; i < length; ++i) printf("%s%.9g", i ? ", " : "", values[i]);
  printf("]");
}
static void print_joints(const void *sample) {
  const sensor_msgs_msg_dds__JointState_ *s = sample;
  printf("{\"sec\": %d, \"nanosec\": %u, \"frame_id\": \"%s\", \"name\": [", s->header.stamp.sec, s->header.stamp.nanosec, s->header.frame_id);
  for (uint32_t i = 0; i < s->name._length; ++i) printf("%s\"%s\"", i ? ", " : "", s->name._buffer[i]);
  printf("]");
  print_list("position", s->position._buffer, s->position._length);
  print_list("velocity", s->velocity._buffer, s->velocity._length);
  print_list("effort", s->effort._buffer, s->effort._length);
  printf("}\n");
}
static void fill_joints(void *sample, int n) {
  static char *names[] = {"a", "bb"};
  static double values[2];
  sensor_msgs_msg_dds__JointState_ *s = sample;
  s->header.stamp.sec = n;
  s->header.frame_id = "base_link";
  s->name._buffer = names;
  s->name._length = s->name._maximum = 2;
  s->position._buffer = values;
  s->position._length = s->position._maximum = 2;
  values[0] = n;
  values[1] = -n;
}

static void print_twist(const void *sample) {
  const geometry_msgs_msg_dds__Twist_ *s = sample;
  printf("{\"linear\": [%g, %g, %g], \"angular\": [%g, %g, %g]}\n", s->linear.x, s->linear.y, s->linear.z, s->angular.x, s->angular.y,
         s->angular.z);
}
static void fill_twist(void *sample, int n) { ((geometry_msgs_msg_dds__Twist_ *)sample)->linear.x = 0.25 * n; }

static const struct message {
  const char *name;
  const dds_topic_descriptor_t *type;
  void (*print)(const void *);
  void (*fill)(void *, int);
} kMessages[] = {{"Float64", &std_msgs_msg_dds__Float64__desc, print_number, fill_number},
                 {"String", &std_msgs_msg_dds__String__desc, print_text, fill_text},
                 {"JointState", &sensor_msgs_msg_dds__JointState__desc, print_joints, fill_joints},
                 {"Twist", &geometry_msgs_msg_dds__Twist__desc, print_twist, fill_twist}};

static const struct message *message_of(const char *name) {
  for (size_t i = 0; i < sizeof kMessages / sizeof *kMessages; ++i) {
    if (strcmp(name, kMessages[i].name) == 0) return &kMessages[i];
  }
  fprintf(stderr, "there is no message %s\n", name);
  exit(2);
}

static dds_entity_t topic_of(dds_entity_t participant, const struct message *message, const char *name) {
  char topic[300];
  snprintf(topic, sizeof topic, "rt%s", name);
  return must(dds_create_topic(participant, message->type, topic, NULL, NULL), topic);
}

static int pub(dds_entity_t participant, int count, char **words) {
  const struct message *message = message_of(words[0]);
  dds_qos_t *qos = profile(count > 4 && strcmp(words[4], "best-effort") == 0);
  const dds_entity_t writer = must(dds_create_writer(participant, topic_of(participant, message, words[1]), qos, NULL), words[1]);
  dds_publication_matched_status_t matched;
  do {
    usleep(10000);
    must(dds_get_publication_matched_status(writer, &matched), "matched");
  } while (matched.current_count == 0);
  usleep(1000000); /* waits until the reader has matched too */
  for (int n = 1; n <= atoi(words[2]); ++n) {
    union {
      std_msgs_msg_dds__Float64_ number;
      std_msgs_msg_dds__String_ text;
      sensor_msgs_msg_dds__JointState_ joints;
      geometry_msgs_msg_dds__Twist_ twist;
    } value;
    memset(&value, 0, sizeof value);
    message->fill(&value, n);
    must(dds_write(writer, &value), "write");
    usleep((useconds_t)atoi(words[3]) * 1000);
  }
  dds_wait_for_acks(writer, DDS_SECS(5));
  printf("written\n");
  return 0;
}

static int sub(dds_entity_t participant, char **words) {
  const struct message *message = message_of(words[0]);
  dds_qos_t *qos = profile(0);
  const dds_entity_t reader = must(dds_create_reader(participant, topic_of(participant, message, words[1]), qos, NULL), words[1]);
  const double end = now() + atof(words[3]);
  int left = atoi(words[2]);
  while (left > 0 && now() < end) {
    void *samples[1] = {NULL};
    dds_sample_info_t info[1];
    const int taken = dds_take(reader, samples, info, 1, 1);
    if (taken > 0 && info[0].valid_data) {
      message->print(samples[0]);
      fflush(stdout);
      --left;
    }
    if (taken > 0) {
      dds_return_loan(reader, samples, taken);
    } else {
      usleep(1000);
    }
  }
  return left > 0 ? 1 : 0;
}

static int list(dds_entity_t participant, double seconds) {
  const struct {
    const char *what;
    dds_entity_t topic;
  } kinds[] = {{"pub", DDS_BUILTIN_TOPIC_DCPSPUBLICATION}, {"sub", DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION}};
  dds_entity_t readers[2];
  for (int i = 0; i < 2; ++i) readers[i] = must(dds_create_reader(participant, kinds[i].topic, NULL, NULL), "reader");
  for (const double end = now() + seconds; now() < end; usleep(10000)) {
    for (int i = 0; i < 2; ++i) {
      void *samples[16] = {NULL};
      dds_sample_info_t info[16];
      const int taken = dds_take(readers[i], samples, info, 16, 16);
      for (int k = 0; k < taken; ++k) {
        const dds_builtintopic_endpoint_t *e = samples[k];
        dds_reliability_kind_t kind = DDS_RELIABILITY_BEST_EFFORT;
        if (!info[k].valid_data || !dds_qget_reliability(e->qos, &kind, NULL)) continue;
        printf("%s %s %s %s\n", kinds[i].what, e->topic_name, e->type_name,
               kind == DDS_RELIABILITY_RELIABLE ? "reliable" : "best-effort");
        fflush(stdout);
      }
      if (taken > 0) dds_return_loan(readers[i], samples, taken);
    }
  }
  return 0;
}

int main(int count, char **words) {
  if (count < 4) return 2;
  const dds_entity_t participant = must(dds_create_participant((dds_domainid_t)atoi(words[1]), NULL, NULL), "participant");
  int status = 2;
  if (strcmp(words[2], "pub") == 0 && count >= 7) status = pub(participant, count - 3, words + 3);
  if (strcmp(words[2], "sub") == 0 && count == 7) status = sub(participant, words + 3);
  if (strcmp(words[2], "list") == 0) status = list(participant, atof(words[3]));
  dds_delete(participant);
  return status;
}
