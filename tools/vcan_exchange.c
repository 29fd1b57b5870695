/* The bare exchange of one control cycle, with no control in it: what the kernel alone costs.
 *
 * Nine processes (master, six joint nodes, gripper, plant) send one another the frames of a cycle
 * on CAN FD raw sockets in lockstep, each with its node's filters: the baseline of bench_vcan.py.
 *
 *   master   SYNC, SETPOINT
 *   plant    on SYNC: MEASURE 1..7
 *   joint n  on SYNC, SETPOINT and MEASURE n: ERROR n; on all six ERRORs: DAC n
 *   gripper  on MEASURE 7: DAC 7
 *   master   on MEASURE 1..6: ROWS 1..6; the cycle ends with 7 MEASURE, 6 ERROR, 7 DAC and its
 *            own 6 ROWS, heard back when they have gone out: 28 frames
 *
 * Every payload starts with the cycle number, which every receiver checks; every joint checks that
 * its row has come. The emergency stop (0x000) ends the exchange.
 *
 * Build: cc -O2 -Wall -Wextra -o vcan_exchange vcan_exchange.c    Usage: see main
 */
#include <errno.h>
#include <error.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { JOINTS = 6, GRIPPER = 7, MASTER = 8, PLANT = 9, NODES = 9 };
enum { ALL_JOINTS = 0x7e, ALL_AXES = 0xfe }; /* bits 1..6 and 1..7: index n of a frame */
enum { SILENCE_LIMIT_S = 10 };

enum frame_id {
    EMERGENCY_STOP = 0x000, NETWORK_MANAGEMENT = 0x001, SYNC = 0x080, EMCY = 0x080,
    MEASURE = 0x100, SETPOINT_1 = 0x140, SETPOINT_2 = 0x141, BIAS = 0x148, GRIPPER_COMMAND = 0x150,
    ERROR = 0x200, DAC = 0x280, ROWS = 0x300, HEARTBEAT = 0x700
};

/* One node's end of the bus, and the frames of the current cycle it has heard, one bit each n. */
struct node {
    unsigned number;
    int socket;
    uint32_t cycle;
    unsigned setpoint, measure, errors, dac, rows;
};

static const char *const node_names[] = {"", "joint 1", "joint 2", "joint 3", "joint 4",
                                         "joint 5", "joint 6", "gripper", "master", "plant"};

static void fail(const struct node *node, const char *what)
{
    error(1, errno, "%s, cycle %u: %s", node_names[node->number], node->cycle, what);
}

static struct can_filter *accept_ids(struct can_filter *filter, unsigned first, unsigned last)
{
    for (unsigned id = first; id <= last; id++)
        *filter++ = (struct can_filter){id, CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK};
    return filter;
}

/* Fills in the filters of a node's role; returns the end of them. */
static struct can_filter *receive_filters(unsigned n, struct can_filter *end)
{
    end = accept_ids(end, EMERGENCY_STOP, EMERGENCY_STOP);
    if (n == MASTER) {
        end = accept_ids(end, MEASURE + 1, MEASURE + GRIPPER);
        end = accept_ids(end, ERROR + 1, ERROR + JOINTS);
        end = accept_ids(end, DAC + 1, DAC + GRIPPER);
        end = accept_ids(end, ROWS + 1, ROWS + JOINTS); /* its own: they have gone out */
        end = accept_ids(end, HEARTBEAT + 1, HEARTBEAT + NODES);
        return accept_ids(end, EMCY + 1, EMCY + NODES);
    }
    end = accept_ids(end, NETWORK_MANAGEMENT, NETWORK_MANAGEMENT);
    end = accept_ids(end, SYNC, SYNC);
    if (n == PLANT)
        return accept_ids(end, DAC + 1, DAC + GRIPPER);
    end = accept_ids(end, MEASURE + n, MEASURE + n);
    if (n == GRIPPER)
        return accept_ids(end, GRIPPER_COMMAND, GRIPPER_COMMAND);
    end = accept_ids(end, SETPOINT_1, SETPOINT_2);
    end = accept_ids(end, BIAS, BIAS);
    end = accept_ids(end, ERROR + 1, ERROR + JOINTS);
    return accept_ids(end, ROWS + n, ROWS + n);
}

static void open_bus(struct node *node)
{
    const int on = 1, own = node->number == MASTER;
    const struct timeval limit = {.tv_sec = SILENCE_LIMIT_S};
    struct can_filter filters[48];
    const struct can_filter *end = receive_filters(node->number, filters);
    const socklen_t size = (socklen_t)((size_t)(end - filters) * sizeof *filters);
    struct sockaddr_can address = {.can_family = AF_CAN};

    node->socket = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    address.can_ifindex = (int)if_nametoindex("vcan0");
    if (node->socket < 0 || !address.can_ifindex ||
        setsockopt(node->socket, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) ||
        setsockopt(node->socket, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &own, sizeof own) ||
        setsockopt(node->socket, SOL_CAN_RAW, CAN_RAW_FILTER, filters, size) ||
        setsockopt(node->socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit) ||
        bind(node->socket, (struct sockaddr *)&address, sizeof address))
        fail(node, "cannot open vcan0");
}

static void send_frame(const struct node *node, unsigned id, uint8_t length)
{
    struct canfd_frame frame = {.can_id = id, .len = length, .flags = CANFD_BRS};

    memcpy(frame.data, &node->cycle, sizeof node->cycle);
    if (write(node->socket, &frame, sizeof frame) != (ssize_t)sizeof frame)
        fail(node, "cannot send");
}

/* Takes the next frame; a SYNC starts the node's next cycle. Returns its identifier. */
static unsigned receive(struct node *node)
{
    struct canfd_frame frame;
    uint32_t cycle;

    errno = 0;
    if (read(node->socket, &frame, sizeof frame) != (ssize_t)sizeof frame)
        fail(node, errno == EAGAIN ? "a frame is missing" : "not a CAN FD frame");
    const unsigned id = frame.can_id & CAN_SFF_MASK, bit = 1u << (id & 0xf);
    memcpy(&cycle, frame.data, sizeof cycle);
    if (id == SYNC) {
        if (node->number <= JOINTS && node->cycle && !node->rows)
            fail(node, "its row is missing");
        *node = (struct node){.number = node->number, .socket = node->socket, .cycle = cycle};
    }
    if (cycle != node->cycle)
        fail(node, "a frame of another cycle");
    switch (id & ~0xfu) {
    case EMERGENCY_STOP: case SYNC: break;
    case MEASURE: node->measure |= bit; break;
    case SETPOINT_1: node->setpoint |= bit; break;
    case ERROR: node->errors |= bit; break;
    case DAC: node->dac |= bit; break;
    case ROWS: node->rows |= bit; break;
    default: fail(node, "an unexpected frame");
    }
    return id;
}

static void run_joint(struct node *node)
{
    const unsigned own = 1u << node->number;

    while (receive(node) != EMERGENCY_STOP) {
        if (!(node->errors & own) && node->setpoint && node->measure) {
            send_frame(node, ERROR + node->number, 16);
            node->errors |= own;
        }
        if (!node->dac && node->errors == ALL_JOINTS) {
            send_frame(node, DAC + node->number, 8);
            node->dac = own;
        }
    }
}

static void run_gripper(struct node *node)
{
    for (unsigned id; (id = receive(node)) != EMERGENCY_STOP;)
        if (id == MEASURE + GRIPPER)
            send_frame(node, DAC + GRIPPER, 8);
}

static void run_plant(struct node *node)
{
    for (unsigned id; (id = receive(node)) != EMERGENCY_STOP;)
        for (unsigned n = 1; id == SYNC && n <= GRIPPER; n++)
            send_frame(node, MEASURE + n, 12);
}

static void run_master(struct node *node, uint32_t cycles)
{
    for (node->cycle = 1; node->cycle <= cycles; node->cycle++) {
        int sent = 0;

        node->measure = node->errors = node->dac = node->rows = 0;
        send_frame(node, SYNC, 12);
        send_frame(node, SETPOINT_1, 64);
        while (node->errors != ALL_JOINTS || node->dac != ALL_AXES ||
               node->measure != ALL_AXES || node->rows != ALL_JOINTS) {
            if (receive(node) == EMERGENCY_STOP)
                fail(node, "an emergency stop of another sender");
            if (sent || (node->measure & ALL_JOINTS) != ALL_JOINTS)
                continue;
            for (unsigned n = 1; n <= JOINTS; n++)
                send_frame(node, ROWS + n, 64);
            sent = 1;
        }
    }
    node->cycle = cycles;
    send_frame(node, EMERGENCY_STOP, 8);
}

static void start_node(struct node *node)
{
    const pid_t parent = getpid(), child = fork();

    if (child < 0)
        fail(node, "cannot fork");
    if (child)
        return;
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) || getppid() != parent) /* it may be dead already */
        _exit(1);
    (node->number == PLANT ? run_plant : node->number == GRIPPER ? run_gripper : run_joint)(node);
    _exit(0);
}

/* Runs the exchange with all nine processes; returns the seconds it took. Every socket is open
 * before the first SYNC, so that no node can miss it. */
static double exchange(uint32_t cycles)
{
    struct node nodes[NODES + 1] = {{0}};
    struct timespec start, stop;

    for (unsigned n = 1; n <= NODES; n++) {
        nodes[n].number = n;
        open_bus(&nodes[n]);
    }
    for (unsigned n = 1; n <= NODES; n++)
        if (n != MASTER)
            start_node(&nodes[n]);
    clock_gettime(CLOCK_MONOTONIC, &start);
    run_master(&nodes[MASTER], cycles);
    clock_gettime(CLOCK_MONOTONIC, &stop);
    return (double)(stop.tv_sec - start.tv_sec) + 1e-9 * (double)(stop.tv_nsec - start.tv_nsec);
}

int main(int argc, char **argv)
{
    const int json = argc == 3 && !strcmp(argv[1], "--json");
    const long cycles = argc == 2 + json ? atol(argv[1 + json]) : 0;

    if (cycles < 1 || cycles > 1000000000) {
        fprintf(stderr, "usage: vcan_exchange [--json] CYCLES (1 to 1000000000)\n");
        return 2;
    }
    const double seconds = exchange((uint32_t)cycles);
    for (int status; wait(&status) > 0;)
        if (status)
            return 1;
    printf(json ? "{\"cycles\": %ld, \"seconds\": %.6f, \"cycles_per_s\": %.3f}\n"
                : "%ld cycles in %.3f s: %.1f cycles/s\n",
           cycles, seconds, (double)cycles / seconds);
    return 0;
}
