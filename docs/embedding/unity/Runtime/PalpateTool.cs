// A tool on a body: a thread of 1 kHz asks the device where it is and gives it the force. MIT licence.
using System.Threading;
using UnityEngine;
using Stopwatch = System.Diagnostics.Stopwatch;

/// A haptic device. The force thread calls both; in world space, Unity's axes, metres and newtons.
public interface IPalpateDevice
{
    void Read(out Vector3 position, out Quaternion rotation);
    void Write(Vector3 force, Vector3 torque);
}

public sealed unsafe class PalpateTool : MonoBehaviour
{
    public PalpateBody body;
    [Tooltip("Of its balls [m]; 0: a tip")] public float radius = 0.005f;
    [Tooltip("Where its balls are in the tool's own axes [m], 8 at most; none: one at its origin")]
    public Vector3[] balls = new Vector3[0];
    [Tooltip("Tools of the same body that this one ticks together with itself: they feel each other")]
    public PalpateTool[] others = new PalpateTool[0];
    [Tooltip("What the device can bear [N]; 0: no cap")] public float maxForce = 3;
    [Tooltip("Forces are brought up over this time [s]")] public float ramp = 0.5f;
    [Tooltip("[Hz]; 0: nothing ticks but Step")] public int rate = 1000;

    /// Set before the tool is enabled; without one the tool goes where its transform is.
    public IPalpateDevice device;

    struct Frame // from the frame's thread to the force thread
    {
        public Vector3 Tool, Body;
        public Quaternion ToolRotation, BodyRotation;
        public float Seconds;
    }
    readonly Frame[] frames = new Frame[3];
    readonly PalpateSlots slots = new PalpateSlots();
    Frame from, to; // what a tool without device glides between
    double glided;
    Thread thread;
    volatile bool isRunning;
    volatile int status;
    int said;
    long ticks;
    PalpateTool leader; // that ticks this one

    /// Of this tool and its others; none where another tool ticks it.
    public PalpateContact Contact { get; private set; }
    /// Of the latest tick, roughly: for pictures, not for devices.
    public Vector3 Force { get; private set; }
    public long Ticks { get { return Interlocked.Read(ref ticks); } }

    public void OnEnable()
    {
        Update();
        from = to = frames[slots.Take() ? slots.Reading : 0];
        if (leader != null) return;
        Palpate.Tool[] shapes = new Palpate.Tool[1 + others.Length];
        shapes[0] = Shape();
        for (int k = 0; k < others.Length; ++k)
        {
            others[k].Stop(); // it may have begun by itself
            others[k].leader = this;
            shapes[1 + k] = others[k].Shape();
        }
        Contact = new PalpateContact(body.Engine, shapes);
        body.Attach(this);
        if (rate <= 0) return;
        isRunning = true;
        thread = new Thread(Loop) { IsBackground = true, Priority = System.Threading.ThreadPriority.Highest };
        thread.Start();
    }

    public void OnDisable()
    {
        Stop();
        foreach (PalpateTool other in others)
        {
            other.Display(Vector3.zero, Vector3.zero);
            other.leader = null; // until it is enabled again
        }
    }

    void Stop()
    {
        isRunning = false;
        if (thread != null) thread.Join();
        thread = null;
        if (Contact != null) body.Detach(this);
        Contact = null;
        Display(Vector3.zero, Vector3.zero);
    }

    Palpate.Tool Shape()
    {
        Palpate.Tool shape = Palpate.Ball(radius);
        shape.MaxForceN = maxForce;
        shape.RampS = ramp;
        if (balls.Length == 0) return shape;
        if (balls.Length > Palpate.MaxBalls) throw new System.ArgumentException("a tool has 8 balls at most");
        shape.Balls = balls.Length;
        for (int i = 0; i < balls.Length; ++i)
        {
            PalpateAxes.ToPalpate(balls[i], shape.CentreM + 3 * i);
            shape.RadiusM[i] = radius;
        }
        return shape;
    }

    public void Update()
    {
        Transform tool = transform, at = body.transform;
        frames[slots.Writing] = new Frame { Tool = tool.position, ToolRotation = tool.rotation, Body = at.position,
            BodyRotation = at.rotation, Seconds = Mathf.Max(Time.deltaTime, 1e-3f) };
        slots.Publish();
        if (status == said) return; // a sentence once, not at 1 kHz
        said = status;
        if (said != Palpate.Ok) Debug.LogWarning("Palpate: " + Palpate.Sentence(said), this);
    }

    /// One tick of this tool and its others, `dt` seconds after the last; the thread calls it. Makes no
    /// garbage.
    public void Step(double dt)
    {
        Feed(dt, Contact.In);
        for (int k = 0; k < others.Length; ++k)
        {
            others[k].Feed(dt, Contact.In + 1 + k);
            Contact.In[1 + k].Body = Contact.In->Body;
        }
        Contact.Tick();
        Feel(Contact.Out);
        for (int k = 0; k < others.Length; ++k) others[k].Feel(Contact.Out + 1 + k);
    }

    void Feed(double dt, Palpate.Input* input)
    {
        if (slots.Take())
        {
            from = Between();
            to = frames[slots.Reading];
            glided = 0;
        }
        glided += dt;
        Frame now = Between();
        if (device != null) device.Read(out now.Tool, out now.ToolRotation);
        PalpateAxes.ToPalpate(now.Tool, input->Tool.PositionM);
        PalpateAxes.ToPalpate(now.ToolRotation, input->Tool.OrientationWxyz);
        PalpateAxes.ToPalpate(now.Body, input->Body.PositionM);
        PalpateAxes.ToPalpate(now.BodyRotation, input->Body.OrientationWxyz);
        input->DtS = System.Math.Max(dt, 1e-5);
    }

    void Feel(Palpate.Output* output)
    {
        status = output->Status;
        Display(PalpateAxes.ToUnity(output->ForceOnToolN), PalpateAxes.ToUnityTorque(output->TorqueOnToolNm));
        Interlocked.Increment(ref ticks);
    }

    void Display(Vector3 force, Vector3 torque)
    {
        Force = force;
        if (device != null) device.Write(force, torque);
    }

    // Between the last two frames, reached one frame late.
    Frame Between()
    {
        float share = to.Seconds > 0 ? Mathf.Min(1, (float)(glided / to.Seconds)) : 1;
        return new Frame { Tool = Vector3.Lerp(from.Tool, to.Tool, share), Body = Vector3.Lerp(from.Body, to.Body, share),
            ToolRotation = Quaternion.Slerp(from.ToolRotation, to.ToolRotation, share),
            BodyRotation = Quaternion.Slerp(from.BodyRotation, to.BodyRotation, share), Seconds = to.Seconds };
    }

    void Loop()
    {
        Stopwatch clock = Stopwatch.StartNew();
        double period = 1.0 / rate, last = 0, next = period;
        while (isRunning)
        {
            double now = clock.Elapsed.TotalSeconds;
            if (now < next)
            {
                if (next - now > 2e-3) Thread.Sleep(1);
                else Thread.SpinWait(20);
                continue;
            }
            Step(now - last);
            last = now;
            next = System.Math.Max(next + period, now - 10 * period); // late ticks are not all made up for
        }
    }
}
