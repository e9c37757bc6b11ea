//! Independent work on several of the processor's cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use erard::Progress;
use erard::run::SimulationError;

/// How often progress is reported to the caller, who may end the work.
const TELL_EVERY: Duration = Duration::from_millis(20);

/// A job; it keeps its own result.
pub(crate) type Job<'a, E> = Box<dyn FnOnce(&mut Progress<'_>) -> Result<(), E> + Send + 'a>;

/// A job that stores its result in `place`.
pub(crate) fn job<'a, T: Send, E>(
    place: &'a mut Option<T>,
    work: impl FnOnce(&mut Progress<'_>) -> Result<T, E> + Send + 'a,
) -> Job<'a, E> {
    Box::new(move |progress| {
        *place = Some(work(progress)?);
        Ok(())
    })
}

/// Number of threads that this process can run in parallel, at least 1.
pub fn count() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// An error that ends the work; an interruption is distinguished from a failure.
pub trait Ending: From<SimulationError> + Send {
    /// Whether the caller asked to stop.
    fn is_interruption(&self) -> bool;
}

impl Ending for SimulationError {
    fn is_interruption(&self) -> bool {
        matches!(self, SimulationError::Interrupted)
    }
}

/// Runs all jobs on the given number of threads; with one, on the caller's own, so that it also works without thread
/// support. `progress` receives the share done and ends the work by returning false. The results do not depend on the
/// number of threads: jobs share no data.
///
/// # Errors
/// The first failed job's error, in job order; [`SimulationError::Interrupted`].
pub(crate) fn do_all<E: Ending>(jobs: Vec<Job<'_, E>>, threads: usize, progress: &mut Progress<'_>) -> Result<(), E> {
    if threads <= 1 {
        return do_all_here(jobs, progress);
    }
    let count = jobs.len();
    let queue: Vec<Mutex<Option<Job<'_, E>>>> = jobs.into_iter().map(|job| Mutex::new(Some(job))).collect();
    let failures: Mutex<Vec<(usize, E)>> = Mutex::new(Vec::new());
    let (next, done, stop) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
    let caller = std::thread::current();
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(place) = queue.get(index) else { break };
            let job = place.lock().ok().and_then(|mut place| place.take());
            if let Some(Err(error)) = job.map(|job| job(&mut |_| !stop.load(Ordering::Relaxed))) {
                stop.store(true, Ordering::Relaxed);
                if let Ok(mut failures) = failures.lock() {
                    failures.push((index, error));
                }
            }
            if done.fetch_add(1, Ordering::Relaxed) + 1 == count {
                caller.unpark();
            }
        }
    };
    let mut interrupted = false;
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.clamp(1, count.max(1))).map(|_| scope.spawn(work)).collect();
        while done.load(Ordering::Relaxed) < count && workers.iter().any(|worker| !worker.is_finished()) {
            if !progress(done.load(Ordering::Relaxed) as f64 / count as f64) {
                interrupted = true;
                stop.store(true, Ordering::Relaxed);
            }
            std::thread::park_timeout(TELL_EVERY);
        }
    });
    if interrupted {
        return Err(SimulationError::Interrupted.into());
    }
    let mut failures = failures.into_inner().unwrap_or_default();
    // A job stopped because another failed is not the reason.
    failures.sort_by_key(|(index, error)| (error.is_interruption(), *index));
    failures.into_iter().next().map_or(Ok(()), |(_, error)| Err(error))
}

/// Does the work for each item on several threads and returns the results in item order, independent of the number of
/// threads. `progress` receives the share done and ends the work by returning false.
///
/// # Errors
/// The first failure, in item order; [`SimulationError::Interrupted`].
pub fn map<I: Sync, T: Send, E: Ending>(
    items: &[I],
    threads: usize,
    progress: &mut Progress<'_>,
    work: impl Fn(&I, &mut Progress<'_>) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let mut found: Vec<Option<T>> = items.iter().map(|_| None).collect();
    let work = &work;
    let jobs = found.iter_mut().zip(items).map(|(place, item)| job(place, move |progress| work(item, progress)));
    do_all(jobs.collect(), threads, progress)?;
    found.into_iter().collect::<Option<Vec<T>>>().ok_or_else(|| SimulationError::Interrupted.into())
}

/// [`do_all`] on the caller's thread, one job after the other. The jobs themselves call `progress`.
fn do_all_here<E: Ending>(jobs: Vec<Job<'_, E>>, progress: &mut Progress<'_>) -> Result<(), E> {
    let count = jobs.len() as f64;
    for (done, job) in jobs.into_iter().enumerate() {
        let mut going = |_: f64| progress(done as f64 / count);
        if !going(0.0) {
            return Err(SimulationError::Interrupted.into());
        }
        job(&mut going)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{MeasureError, NotAnAction};

    #[test]
    fn every_job_is_done_and_the_first_failure_told() {
        for threads in [1, 2, 7] {
            let mut places = vec![None; 20];
            let jobs = places.iter_mut().enumerate().map(|(i, place)| job(place, move |_| Ok(i * i))).collect();
            do_all::<MeasureError>(jobs, threads, &mut |_| true).unwrap();
            assert!(places.iter().enumerate().all(|(i, place)| *place == Some(i * i)));
        }

        let (mut a, mut b) = (None::<()>, None::<()>);
        let waiting = job(&mut a, |progress| {
            while progress(0.0) {
                std::thread::yield_now();
            }
            Err(SimulationError::Interrupted.into())
        });
        let error = do_all(vec![waiting, job(&mut b, |_| Err(NotAnAction::Weightless.into()))], 2, &mut |_| true);
        assert!(matches!(error, Err(MeasureError::NotAnAction(NotAnAction::Weightless))));
    }

    #[test]
    fn an_interruption_ends_all() {
        let mut place = None::<()>;
        let waiting = job(&mut place, |progress| {
            while progress(0.0) {
                std::thread::yield_now();
            }
            Err(SimulationError::Interrupted.into())
        });
        assert!(do_all::<MeasureError>(vec![waiting], 1, &mut |_| false).unwrap_err().is_interruption());
    }

    #[test]
    fn no_jobs_are_done_at_once() {
        do_all::<SimulationError>(Vec::new(), 2, &mut |_| true).unwrap();
    }
}
